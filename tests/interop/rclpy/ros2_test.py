# SPDX-License-Identifier: Apache-2.0
"""The ros2 commands beside a robot of ours: they must find nothing that rclcpp's nodes do not have.
Started by beside_ros2."""
import re
import signal
import subprocess
import tempfile
import unittest

import rclpy_node
import robot
from rclpy_node import CONTAINER, NODES, names
from robot import ros2, says, until


def setUpModule():
    unittest.addModuleCleanup(ros2, 'daemon', 'stop')  # some commands start the daemon
    rclpy_node.start_robot()


class TheGraph(unittest.TestCase):
    def test_lists_our_nodes_and_no_others(self):
        listed = [name for name in says('/map_server.*/tandem_container', 'node', 'list').split()
                  if name != '/beside' and not name.startswith('/_')]
        self.assertEqual(sorted(listed), sorted(NODES | {CONTAINER}))

    def test_tells_of_a_node_what_it_tells_of_rclcpps(self):
        said = says('Service Servers:.*set_parameters_atomically', 'node', 'info', '/local_planner')
        subscribers, rest = said.split('  Publishers:')
        publishers, rest = rest.split('  Service Servers:')
        services = rest.split('  Service Clients:')[0]
        for line in ['/obstacles: tandem_msgs/msg/ObstacleArray', '/odom: nav_msgs/msg/Odometry']:
            self.assertIn(f'    {line}\n', subscribers)
        for line in ['/parameter_events: rcl_interfaces/msg/ParameterEvent', '/plan: nav_msgs/msg/Path',
                     '/rosout: rcl_interfaces/msg/Log']:
            self.assertIn(f'    {line}\n', publishers)
        for name, kind in {
                'describe_parameters': 'rcl_interfaces/srv/DescribeParameters',
                'get_parameter_types': 'rcl_interfaces/srv/GetParameterTypes',
                'get_parameters': 'rcl_interfaces/srv/GetParameters',
                'get_type_description': 'type_description_interfaces/srv/GetTypeDescription',
                'list_parameters': 'rcl_interfaces/srv/ListParameters',
                'set_parameters': 'rcl_interfaces/srv/SetParameters',
                'set_parameters_atomically': 'rcl_interfaces/srv/SetParametersAtomically'}.items():
            self.assertIn(f'    /local_planner/{name}: {kind}\n', services)

    def test_lists_topics_and_services_with_their_types(self):
        topics = says(r'^/cmd_vel \[', 'topic', 'list', '-t')
        for line in ['/cmd_vel [geometry_msgs/msg/Twist]',
                     '/map [nav_msgs/msg/OccupancyGrid]', '/obstacles [tandem_msgs/msg/ObstacleArray]',
                     '/octomap_binary [octomap_msgs/msg/Octomap]', '/tf [tf2_msgs/msg/TFMessage]']:
            self.assertIn(line + '\n', topics)
        services = says('/diff_drive_sim/reset.*/_container/load_node', 'service', 'list', '-t',
                        '--include-hidden-services')
        for line in ['/diff_drive_sim/reset [std_srvs/srv/Trigger]',
                     '/tandem_container/_container/load_node [composition_interfaces/srv/LoadNode]',
                     '/teleop/set_parameters [rcl_interfaces/srv/SetParameters]']:
            self.assertIn(line + '\n', services)

    def test_describes_the_endpoints_of_a_topic(self):
        said = says('Node name: safety_filter.*Node name: diff_drive_sim', 'topic', 'info', '-v', '/cmd_vel')
        self.assertNotRegex(said, 'INVALID|UNKNOWN_|BARE')
        self.assertIn('Lifespan: 200000000 nanoseconds', said)


class Topics(unittest.TestCase):
    def test_are_echoed_and_measured(self):
        says('frame_id: odom', 'topic', 'echo', '--once', '/odom', ask=ros2)
        says('semi_axis_a: ', 'topic', 'echo', '--once', '/obstacles', ask=ros2)
        hz = subprocess.Popen(['ros2', 'topic', 'hz', '/odom'], stdout=subprocess.PIPE, text=True)
        measured = any('average rate' in line for line in hz.stdout)  # stops at the first such line
        hz.send_signal(signal.SIGINT)
        hz.communicate(timeout=robot.PATIENCE)
        self.assertTrue(measured)

    def test_of_the_log_are_echoed(self):
        says(r'level: \d+\nname: .+\nmsg: .+\nfile: .*\.cpp.*\nfunction: .+\nline: \d+',
             'topic', 'echo', '--once', '/rosout', ask=ros2)


class Services(unittest.TestCase):
    def test_of_ours_answer_the_command(self):
        says('success=True', 'service', 'call', '/diff_drive_sim/reset', 'std_srvs/srv/Trigger', ask=ros2)


class Parameters(unittest.TestCase):
    def test_are_listed_described_got_and_set(self):
        self.assertIn('  weight_heading\n', says('weight_heading', 'param', 'list', '/local_planner'))
        says(r'Type: double\n\s+Description: [^\n]+\n\s+Constraints:\n\s+Min value: ',
             'param', 'describe', '/local_planner', 'weight_heading')
        says('Set parameter successful', 'param', 'set', '/local_planner', 'weight_heading', '2.5')
        says('Double value is: 2.5', 'param', 'get', '/local_planner', 'weight_heading')

    def test_of_a_bad_value_are_refused_with_the_reason(self):
        says('Setting parameter failed: .*weight_heading',
             'param', 'set', '/local_planner', 'weight_heading', '20000.0')

    def test_are_dumped_and_loaded_back(self):
        says('successful', 'param', 'set', '/teleop', 'scale_linear', '0.7')
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
            file.write(says('ros__parameters', 'param', 'dump', '/teleop'))
            file.flush()
            says('successful', 'param', 'set', '/teleop', 'scale_linear', '0.6')
            says('Set parameter scale_linear successful', 'param', 'load', '/teleop', file.name)
        says('0.7', 'param', 'get', '/teleop', 'scale_linear')


class Components(unittest.TestCase):
    def test_are_loaded_listed_and_unloaded(self):
        said = says(r"Loaded component \d+ into '/tandem_container' container node as '/two/second'",
                    'component', 'load', '/tandem_container', 'tandem_local_planner',
                    'tandem::LocalPlanner', '-n', 'second', '--node-namespace', '/two',
                    '-p', 'weight_heading:=3.0', '-r', 'plan:=other_plan')
        number = re.search(r'component (\d+)', said)[1]
        until(lambda: '/two/second' in names(), 'the component is seen')
        says(rf'/tandem_container\s+{number}\s+/two/second', 'component', 'list')
        says('3.0', 'param', 'get', '/two/second', 'weight_heading')
        until(lambda: '/two/other_plan' in dict(rclpy_node.node.get_topic_names_and_types()), 'the remapped topic')
        says(f"Unloaded component {number} from '/tandem_container'",
             'component', 'unload', '/tandem_container', number)
        until(lambda: '/two/second' not in names(), 'the component is gone')

    def test_that_are_none_are_refused_with_the_reason(self):
        says('Failed to load component.*nonsense',
             'component', 'load', '/tandem_container', 'tandem', 'tandem::Nonsense')


if __name__ == '__main__':
    unittest.main()

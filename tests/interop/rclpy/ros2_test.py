# SPDX-License-Identifier: Apache-2.0
"""rclpy and the ros2 commands beside a robot of ours: they must find nothing that rclcpp's nodes do
not have. Started by beside_ros2."""
import re
import signal
import subprocess
import tempfile
import unittest

import robot
from robot import ros2, says, start, stop, until

DOMAIN = robot.take_domain()

import rclpy  # noqa: E402  reads ROS_DOMAIN_ID
from rcl_interfaces.msg import LoggerLevel  # noqa: E402
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels  # noqa: E402
from rclpy.qos import (DurabilityPolicy, QoSPresetProfiles, QoSProfile,  # noqa: E402
                       ReliabilityPolicy)
from rosidl_runtime_py.utilities import get_message  # noqa: E402
from geometry_msgs.msg import Twist, TwistStamped  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402
from std_msgs.msg import Bool  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from tandem_msgs.msg import ArbitrationStatus, ObstacleArray  # noqa: E402
from type_description_interfaces.srv import GetTypeDescription  # noqa: E402

NODES = {'/map_server', '/joystick', '/teleop', '/obstacle_extractor', '/local_planner', '/arbitration',
         '/safety_filter', '/haptics', '/dashboard', '/diff_drive_sim'}
SYSTEM = robot.SOURCE + '/bringup/systems/teleop.yaml'
RELIABLE, BEST_EFFORT = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL


def setUpModule():
    global node
    programs = [start('tandem', 'run', SYSTEM, '--ros-args', '-p', 'dashboard:port:=0',
                      '-p', 'arbitration:policy:=manual'),
                start('tandem', 'container')]
    unittest.addModuleCleanup(end, programs)
    rclpy.init()
    node = rclpy.create_node('beside')
    until(lambda: NODES | {'/tandem_container'} <= names(), 'our nodes are seen')


def end(programs):
    node.destroy_node()
    rclpy.shutdown()
    ros2('daemon', 'stop')  # some commands start the daemon
    results = [stop(program) for program in programs]
    if results != [0, 0]:
        raise AssertionError(f'robot and container ended with {results}')


def names():
    return {(ns.rstrip('/') + '/' + name) for name, ns in node.get_node_names_and_namespaces()}


def spin_until(condition, what):
    def turn():
        rclpy.spin_once(node, timeout_sec=0.02)
        return condition()
    return until(turn, what)


def call(client, request):
    """The answer, asked for once: none may be lost to discovery."""
    if not client.wait_for_service(robot.PATIENCE):
        raise AssertionError(f'{client.srv_name} is not there')
    future = client.call_async(request)
    spin_until(future.done, client.srv_name)
    return future.result()


class Heard:
    """The messages of a topic."""

    def __init__(self, kind, topic, qos):
        self.messages = []
        self.subscription = node.create_subscription(kind, topic, self.messages.append, qos)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        node.destroy_subscription(self.subscription)

    def next(self, matches=lambda message: True):
        del self.messages[:]
        spin_until(lambda: any(map(matches, self.messages)), self.subscription.topic_name)
        return next(filter(matches, self.messages))


class TheGraph(unittest.TestCase):
    def test_lists_our_nodes_and_no_others(self):
        listed = [name for name in says('/map_server.*/tandem_container', 'node', 'list').split()
                  if name != '/beside' and not name.startswith('/_')]
        self.assertEqual(sorted(listed), sorted(NODES | {'/tandem_container'}))

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

    def endpoints(self):
        for topic, _ in node.get_topic_names_and_types():
            yield from node.get_publishers_info_by_topic(topic)
            yield from node.get_subscriptions_info_by_topic(topic)

    def test_knows_the_node_of_every_endpoint(self):
        def nameless():
            return [f'{end.topic_type} of {end.node_name}' for end in self.endpoints()
                    if end.node_name.startswith('_CREATED_BY_BARE') or end.node_name == '_NODE_NAME_UNKNOWN_']
        until(lambda: not nameless(), f'every endpoint has a node, not {nameless()}')

    def test_gets_the_type_hashes_that_rosidl_computed(self):
        ours = {}
        for end in self.endpoints():
            if end.node_name != 'beside':
                ours.setdefault(end.topic_type, set()).add(str(end.topic_type_hash))
        self.assertGreater(len(ours), 15)
        for number, (kind, hashes) in enumerate(sorted(ours.items())):
            publisher = node.create_publisher(get_message(kind), f'hash_{number}', 1)
            [local] = node.get_publishers_info_by_topic(f'/hash_{number}')
            self.assertEqual(hashes, {str(local.topic_type_hash)}, kind)
            node.destroy_publisher(publisher)

    def qos_of(self, topic, owner):
        found = [end for end in node.get_publishers_info_by_topic(topic) if end.node_name == owner]
        self.assertEqual(len(found), 1, topic)
        return found[0].qos_profile

    def test_shows_the_qos_of_rclcpps_topics(self):
        mine = {topic: self.qos_of(topic, 'beside') for topic in ['/rosout', '/parameter_events']}
        for topic, qos in mine.items():
            theirs = self.qos_of(topic, 'local_planner')
            for policy in ['reliability', 'durability', 'lifespan', 'deadline', 'liveliness',
                           'liveliness_lease_duration']:
                self.assertEqual(getattr(theirs, policy), getattr(qos, policy), f'{policy} of {topic}')

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

    def test_forgets_a_killed_process_by_its_liveliness(self):
        peer = start('tests/peer', 'trigger')
        until(lambda: '/server' in names(), 'the peer is seen')
        peer.kill()
        peer.wait()
        until(lambda: '/server' not in names(), 'the killed peer is gone')


class Topics(unittest.TestCase):
    def test_are_echoed_and_measured(self):
        says('frame_id: odom', 'topic', 'echo', '--once', '/odom', ask=ros2)
        says('semi_axis_a: ', 'topic', 'echo', '--once', '/obstacles', ask=ros2)
        hz = subprocess.Popen(['ros2', 'topic', 'hz', '/odom'], stdout=subprocess.PIPE, text=True)
        measured = any('average rate' in line for line in hz.stdout)  # stops at the first such line
        hz.send_signal(signal.SIGINT)
        hz.communicate(timeout=robot.PATIENCE)
        self.assertTrue(measured)

    def test_carry_our_own_types(self):
        with Heard(ObstacleArray, '/obstacles', QoSPresetProfiles.SYSTEM_DEFAULT.value) as heard:
            obstacles = heard.next(lambda message: message.obstacles)
        self.assertEqual(obstacles.header.frame_id, 'map')

    def drive(self, kind, command, moves):
        """Commands as the person does until the robot's odometry agrees; then lets it stand."""
        publisher = node.create_publisher(kind, '/cmd_vel_user', 1)
        with Heard(Odometry, '/odom', QoSPresetProfiles.SENSOR_DATA.value) as odometry:
            def turn():
                publisher.publish(command())
                rclpy.spin_once(node, timeout_sec=0.02)
                return any(moves(odom.twist.twist) for odom in odometry.messages)
            until(turn, f'the robot obeys a {kind.__name__}')
            node.destroy_publisher(publisher)
            odometry.next(lambda odom: abs(odom.twist.twist.angular.z) < 0.01)

    def test_of_both_velocity_types_drive_the_robot(self):
        def twist():
            command = Twist()
            command.angular.z = 0.3
            return command

        def stamped():
            command = TwistStamped()
            command.header.stamp = clock.messages[-1].header.stamp
            command.header.frame_id = 'base_link'
            command.twist.angular.z = -0.3
            return command

        self.drive(Twist, twist, lambda speed: speed.angular.z > 0.1)
        with Heard(Odometry, '/odom', 1) as clock:
            clock.next()
            self.drive(TwistStamped, stamped, lambda speed: speed.angular.z < -0.1)

    def test_of_an_emergency_stop_are_heard_from_every_kind_of_sender(self):
        release = node.create_client(Trigger, '/arbitration/release_emergency_stop')
        for reliability in [RELIABLE, BEST_EFFORT]:
            for durability in [VOLATILE, LATCHED]:
                with self.subTest(reliability=reliability.name, durability=durability.name):
                    self.stop_and_release(QoSProfile(depth=1, reliability=reliability,
                                                     durability=durability), release)

    def stop_and_release(self, qos, release):
        publisher = node.create_publisher(Bool, '/e_stop', qos)
        with Heard(ArbitrationStatus, '/arbitration/status', 10) as status:
            def pressed():
                publisher.publish(Bool(data=True))
                rclpy.spin_once(node, timeout_sec=0.02)
                return any(message.emergency_stop for message in status.messages)
            until(pressed, 'the robot stops')

            def released():
                publisher.publish(Bool(data=False))
                return call(release, Trigger.Request()).success
            until(released, 'the stop is released')
            status.next(lambda message: not message.emergency_stop)
            node.destroy_publisher(publisher)

    def test_of_the_log_are_echoed(self):
        says(r'level: \d+\nname: .+\nmsg: .+\nfile: .*\.cpp.*\nfunction: .+\nline: \d+',
             'topic', 'echo', '--once', '/rosout', ask=ros2)


class Services(unittest.TestCase):
    def test_of_ours_answer_the_command(self):
        says('success=True', 'service', 'call', '/diff_drive_sim/reset', 'std_srvs/srv/Trigger', ask=ros2)

    def test_of_ours_lose_no_answer_of_a_new_client(self):
        for _ in range(10):
            client = node.create_client(Trigger, '/diff_drive_sim/reset')
            self.assertTrue(call(client, Trigger.Request()).success)
            node.destroy_client(client)

    def test_of_rclpys_answer_our_client(self):
        def answer(_, response):
            response.success, response.message = True, 'from rclpy'
            return response
        service = node.create_service(Trigger, '/trigger', answer)
        peer = subprocess.Popen([robot.BINARY + '/tests/peer', 'ask'], stdout=subprocess.PIPE, text=True)
        spin_until(lambda: peer.poll() is not None, 'the peer ends')
        self.assertEqual(peer.communicate()[0], 'from rclpy\n')
        node.destroy_service(service)

    def test_of_loggers_set_the_level(self):
        request = SetLoggerLevels.Request()
        request.levels = [LoggerLevel(name='teleop', level=10)]
        client = node.create_client(SetLoggerLevels, '/teleop/set_logger_levels')
        self.assertTrue(call(client, request).results[0].successful)
        asks = node.create_client(GetLoggerLevels, '/teleop/get_logger_levels')
        self.assertEqual(call(asks, GetLoggerLevels.Request(names=['teleop'])).levels[0].level, 10)

    def test_of_types_describe_what_we_publish(self):
        [end] = node.get_publishers_info_by_topic('/obstacles')
        request = GetTypeDescription.Request(type_name=end.topic_type, type_hash=str(end.topic_type_hash))
        client = node.create_client(GetTypeDescription, f'/{end.node_name}/get_type_description')
        answer = call(client, request)
        self.assertTrue(answer.successful, answer.failure_reason)
        self.assertEqual(answer.type_description.type_description.type_name, 'tandem_msgs/msg/ObstacleArray')


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
        until(lambda: '/two/other_plan' in dict(node.get_topic_names_and_types()), 'the remapped topic')
        says(f"Unloaded component {number} from '/tandem_container'",
             'component', 'unload', '/tandem_container', number)
        until(lambda: '/two/second' not in names(), 'the component is gone')

    def test_that_are_none_are_refused_with_the_reason(self):
        says('Failed to load component.*nonsense',
             'component', 'load', '/tandem_container', 'tandem', 'tandem::Nonsense')


if __name__ == '__main__':
    unittest.main()

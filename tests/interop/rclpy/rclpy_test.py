# SPDX-License-Identifier: Apache-2.0
"""rclpy beside a robot of ours: it must find nothing that rclcpp's nodes do not have. Needs no `ros2`
command and, except where a test names them, not our messages. Run through with_rclpy or beside_ros2."""
import importlib
import subprocess
import tempfile
import unittest
from xml.etree import ElementTree

import rclpy_node
import robot
from rclpy_node import CONTAINER, NODES, Received, call, names, result_of, spin_until
from robot import start, stop, until

import rclpy
from rcl_interfaces.msg import Log, LoggerLevel, ParameterType
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSPresetProfiles, QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from std_msgs.msg import Bool, String
from service_msgs.msg import ServiceEventInfo
from std_srvs.srv import Trigger
from type_description_interfaces.srv import GetTypeDescription

try:
    from tandem_msgs.msg import ArbitrationStatus, ObstacleArray
    NOT_INSTALLED = set()
except ModuleNotFoundError:
    ArbitrationStatus = ObstacleArray = None
    NOT_INSTALLED = {'octomap_msgs', 'tandem_msgs', 'tf2_msgs'}

RELIABLE, BEST_EFFORT = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL
of_our_messages = unittest.skipUnless(ObstacleArray, 'this Python has no tandem_msgs')


def setUpModule():
    global node
    rclpy_node.start_robot()
    node = rclpy_node.node


def message_type(name):
    package, _, kind = name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), kind)


def press_and_release(qos, release, stopped):
    publisher = node.create_publisher(Bool, '/e_stop', qos)

    def pressed():
        publisher.publish(Bool(data=True))
        rclpy.spin_once(node, timeout_sec=0.02)
        return stopped()
    until(pressed, 'the robot stops')

    def released():
        publisher.publish(Bool(data=False))
        return call(release, Trigger.Request()).success
    until(released, 'the stop is released')
    node.destroy_publisher(publisher)


class TheGraph(unittest.TestCase):
    def test_has_our_nodes_and_no_others(self):
        others = names() - {'/beside'}
        self.assertEqual({name for name in others if not name.startswith('/_')}, NODES | {CONTAINER})

    def test_tells_of_a_node_what_it_tells_of_rclcpps(self):
        def of_planner(get):
            return {name: kinds[0] for name, kinds in get('local_planner', '/')}
        subscriptions = of_planner(node.get_subscriber_names_and_types_by_node)
        publishers = of_planner(node.get_publisher_names_and_types_by_node)
        services = of_planner(node.get_service_names_and_types_by_node)
        expected = {'/obstacles': 'tandem_msgs/msg/ObstacleArray', '/odom': 'nav_msgs/msg/Odometry'}
        self.assertEqual(expected, {name: subscriptions.get(name) for name in expected})
        expected = {'/parameter_events': 'rcl_interfaces/msg/ParameterEvent', '/plan': 'nav_msgs/msg/Path',
                    '/rosout': 'rcl_interfaces/msg/Log'}
        self.assertEqual(expected, {name: publishers.get(name) for name in expected})
        expected = {f'/local_planner/{name}': kind for name, kind in {
            'describe_parameters': 'rcl_interfaces/srv/DescribeParameters',
            'get_parameter_types': 'rcl_interfaces/srv/GetParameterTypes',
            'get_parameters': 'rcl_interfaces/srv/GetParameters',
            'get_type_description': 'type_description_interfaces/srv/GetTypeDescription',
            'list_parameters': 'rcl_interfaces/srv/ListParameters',
            'set_parameters': 'rcl_interfaces/srv/SetParameters',
            'set_parameters_atomically': 'rcl_interfaces/srv/SetParametersAtomically'}.items()}
        self.assertEqual(expected, {name: services.get(name) for name in expected})

    def test_has_topics_and_services_with_their_types(self):
        def there():
            found = dict(node.get_topic_names_and_types() + node.get_service_names_and_types())
            return all(found.get(name) == [kind] for name, kind in {
                '/cmd_vel': 'geometry_msgs/msg/Twist',
                '/map': 'nav_msgs/msg/OccupancyGrid',
                '/obstacles': 'tandem_msgs/msg/ObstacleArray',
                '/octomap_binary': 'octomap_msgs/msg/Octomap',
                '/tf': 'tf2_msgs/msg/TFMessage',
                '/diff_drive_sim/reset': 'std_srvs/srv/Trigger',
                f'{CONTAINER}/_container/load_node': 'composition_interfaces/srv/LoadNode',
                '/teleop/set_parameters': 'rcl_interfaces/srv/SetParameters'}.items())
        until(there, 'topics and services with their types')

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
        compared = {kind: hashes for kind, hashes in sorted(ours.items())
                    if kind.split('/')[0] not in NOT_INSTALLED}
        self.assertGreater(len(compared), 10)
        for number, (kind, hashes) in enumerate(compared.items()):
            publisher = node.create_publisher(message_type(kind), f'hash_{number}', 1)
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

    def test_shows_the_lifespan_of_a_command(self):
        self.assertEqual(self.qos_of('/cmd_vel', 'safety_filter').lifespan, Duration(seconds=0.2))

    def test_forgets_a_killed_process_by_its_liveliness(self):
        peer = start('tests/peer', 'trigger')
        until(lambda: '/server' in names(), 'the peer is seen')
        peer.kill()
        peer.wait()
        until(lambda: '/server' not in names(), 'the killed peer is gone')


class Topics(unittest.TestCase):
    def test_of_maps_reach_a_late_subscriber(self):
        with Received(OccupancyGrid, '/map', QoSProfile(depth=1, durability=LATCHED)) as maps:
            map_ = maps.any()
        self.assertEqual(map_.header.frame_id, 'map')
        self.assertEqual(len(map_.data), map_.info.width * map_.info.height)
        self.assertIn(100, map_.data)

    def test_of_the_robots_shape_is_a_urdf_document(self):
        with Received(String, '/robot_description', QoSProfile(depth=1, durability=LATCHED)) as descriptions:
            urdf = ElementTree.fromstring(descriptions.any().data)
        self.assertEqual([link.get('name') for link in urdf.findall('link')], ['base_link'])
        self.assertEqual(urdf.find('link/visual/geometry/box').get('size').split()[:2], ['0.89', '0.58'])
        self.assertEqual(len(urdf.findall('link/visual/geometry/cylinder')), 2)

    @of_our_messages
    def test_carry_our_own_types(self):
        with Received(ObstacleArray, '/obstacles', QoSPresetProfiles.SYSTEM_DEFAULT.value) as received:
            obstacles = received.next(lambda message: message.obstacles)
        self.assertEqual(obstacles.header.frame_id, 'map')

    def drive(self, kind, command, moves):
        """Commands as the person does until the robot's odometry agrees; then lets it stand."""
        publisher = node.create_publisher(kind, '/cmd_vel_user', 1)
        with Received(Odometry, '/odom', QoSPresetProfiles.SENSOR_DATA.value) as odometry:
            def turn():
                publisher.publish(command())
                rclpy.spin_once(node, timeout_sec=0.02)
                return any(moves(odom.twist.twist) for odom in odometry.messages)
            until(turn, f'the robot obeys a {kind.__name__}')
            node.destroy_publisher(publisher)
            odometry.next(lambda odom: abs(odom.twist.twist.angular.z) < 0.01)

    def let_go_of_the_stick(self):
        """As the robot demands after an emergency stop, which another test may have pressed."""
        publisher = node.create_publisher(Twist, '/cmd_vel_user', 1)
        with Received(Odometry, '/odom', QoSPresetProfiles.SENSOR_DATA.value) as odometry:
            begin = Time.from_msg(odometry.next().header.stamp)

            def turn():
                publisher.publish(Twist())
                rclpy.spin_once(node, timeout_sec=0.02)
                return Time.from_msg(odometry.messages[-1].header.stamp) - begin > Duration(seconds=1.5)
            until(turn, 'the stick rests')
        node.destroy_publisher(publisher)

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

        self.let_go_of_the_stick()
        self.drive(Twist, twist, lambda speed: speed.angular.z > 0.1)
        with Received(Odometry, '/odom', 1) as clock:
            clock.next()
            self.drive(TwistStamped, stamped, lambda speed: speed.angular.z < -0.1)
        # `ros2 topic echo` and `ros2 bag record` refuse a topic with two types.
        until(lambda: dict(node.get_topic_names_and_types())['/cmd_vel_user'] == ['geometry_msgs/msg/Twist']
              and not [name for name in names() if name.endswith('_2')], 'one type is left')

    def test_of_an_emergency_stop_are_received_from_every_kind_of_sender(self):
        release = node.create_client(Trigger, '/arbitration/release_emergency_stop')
        for reliability in [RELIABLE, BEST_EFFORT]:
            for durability in [VOLATILE, LATCHED]:
                with self.subTest(reliability=reliability.name, durability=durability.name):
                    self.stop_and_release(QoSProfile(depth=1, reliability=reliability,
                                                     durability=durability), release)

    def stop_and_release(self, qos, release):
        with Received(Log, '/rosout', QoSProfile(depth=1000)) as log:
            def logged(text):
                return any(line.name == 'arbitration' and line.msg == text for line in log.messages)
            press_and_release(qos, release, lambda: logged('emergency stop'))
            spin_until(lambda: logged('release of the emergency stop: released'), 'the release is logged')

    def test_of_an_emergency_stop_match_a_volatile_publisher_without_a_warning(self):
        def readers():
            return [end.qos_profile.durability for end in node.get_subscriptions_info_by_topic('/e_stop')]
        until(lambda: readers() == [VOLATILE, VOLATILE], 'latched publishers of other tests are forgotten')
        warnings = []
        publisher = node.create_publisher(
            Bool, '/e_stop', 10, event_callbacks=PublisherEventCallbacks(incompatible_qos=warnings.append))
        spin_until(lambda: publisher.get_subscription_count() == 2, 'as `ros2 topic pub -w 2` waits')
        self.assertEqual(readers(), [VOLATILE, VOLATILE])
        self.assertEqual(warnings, [])
        node.destroy_publisher(publisher)

    @of_our_messages
    def test_of_the_arbitration_show_the_emergency_stop(self):
        release = node.create_client(Trigger, '/arbitration/release_emergency_stop')
        with Received(ArbitrationStatus, '/arbitration/status', 10) as status:
            press_and_release(QoSProfile(depth=1), release,
                              lambda: any(message.emergency_stop for message in status.messages))
            status.next(lambda message: not message.emergency_stop)


class Services(unittest.TestCase):
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

    def test_are_told_of_as_rclcpp_tells(self):
        simulator = AsyncParameterClient(node, '/diff_drive_sim')
        self.assertTrue(simulator.wait_for_services(robot.PATIENCE))

        def introspect(state):
            change = [Parameter('service_configure_introspection', Parameter.Type.STRING, state)]
            self.assertTrue(result_of(simulator.set_parameters(change), state).results[0].successful)
        topic = '/diff_drive_sim/reset/_service_event'
        introspect('contents')
        with Received(Trigger.Event, topic, QoSPresetProfiles.SERVICES_DEFAULT.value) as events:
            spin_until(lambda: node.count_publishers(topic) == 1, 'the topic of events')
            [ours] = node.get_publishers_info_by_topic(topic)
            [theirs] = node.get_subscriptions_info_by_topic(topic)
            self.assertEqual(str(ours.topic_type_hash), str(theirs.topic_type_hash))
            answer = call(node.create_client(Trigger, '/diff_drive_sim/reset'), Trigger.Request())
            spin_until(lambda: len(events.messages) >= 2, 'both events')
        introspect('disabled')
        received, sent = events.messages
        self.assertEqual((received.info.event_type, sent.info.event_type),
                         (ServiceEventInfo.REQUEST_RECEIVED, ServiceEventInfo.RESPONSE_SENT))
        self.assertEqual((received.request, received.response), ([Trigger.Request()], []))
        self.assertEqual((sent.request, sent.response), ([], [answer]))
        self.assertEqual(received.info.sequence_number, sent.info.sequence_number)

    def test_of_types_describe_as_rclpys_do(self):
        publisher = node.create_publisher(PoseStamped, '/described', 1)
        [end] = node.get_publishers_info_by_topic('/described')
        request = GetTypeDescription.Request(type_name=end.topic_type, type_hash=str(end.topic_type_hash))

        def description_by(owner):
            answer = call(node.create_client(GetTypeDescription, f'/{owner}/get_type_description'), request)
            self.assertTrue(answer.successful, answer.failure_reason)
            return (answer.type_description,
                    [(source.type_name, source.encoding) for source in answer.type_sources])
        ours = description_by('local_planner')
        self.assertEqual(ours, description_by('beside'))
        self.assertIn("default_value='1.0'", str(ours), "a quaternion's w")
        node.destroy_publisher(publisher)

    def test_of_the_recorder_are_those_of_rosbag2s(self):
        with tempfile.TemporaryDirectory() as folder:
            recorder = start('tandem', 'record', '-o', folder + '/drive', '/odom')

            def served():
                if '/tandem_record' not in names():
                    return {}
                return dict(node.get_service_names_and_types_by_node('tandem_record', '/'))
            expected = {f'/tandem_record/{name}': [f'rosbag2_interfaces/srv/{kind}'] for name, kind in {
                'record': 'Record', 'stop': 'Stop', 'pause': 'Pause', 'resume': 'Resume',
                'is_paused': 'IsPaused'}.items()}
            until(lambda: expected.items() <= served().items(), 'the services of the recorder')
            self.assertEqual(stop(recorder), 0)


class Parameters(unittest.TestCase):
    def setUp(self):
        self.planner = AsyncParameterClient(node, '/local_planner')
        self.assertTrue(self.planner.wait_for_services(robot.PATIENCE))

    def set(self, value):
        change = [Parameter('weight_heading', Parameter.Type.DOUBLE, value)]
        return result_of(self.planner.set_parameters(change), 'set_parameters').results[0]

    def test_are_listed_described_got_and_set(self):
        listed = result_of(self.planner.list_parameters(), 'list_parameters').result.names
        self.assertIn('weight_heading', listed)
        [described] = result_of(self.planner.describe_parameters(['weight_heading']),
                                'describe_parameters').descriptors
        self.assertEqual(described.type, ParameterType.PARAMETER_DOUBLE)
        self.assertTrue(described.description)
        self.assertLess(described.floating_point_range[0].from_value, described.floating_point_range[0].to_value)
        self.assertTrue(self.set(2.5).successful)
        [value] = result_of(self.planner.get_parameters(['weight_heading']), 'get_parameters').values
        self.assertEqual(value.double_value, 2.5)

    def test_are_refused_with_the_words_of_rclcpp(self):
        def reason_of(name, kind, value):
            [refused] = result_of(self.planner.set_parameters([Parameter(name, kind, value)]),
                                  'set_parameters').results
            self.assertFalse(refused.successful)
            return refused.reason
        self.assertTrue(reason_of('weight_heading', Parameter.Type.DOUBLE, 20000.0).startswith(
            "Parameter {weight_heading} doesn't comply with floating point range. "))
        self.assertEqual(reason_of('weight_heading', Parameter.Type.STRING, 'much'),
                         'Wrong parameter type, parameter {weight_heading} is of type {double}, setting it to '
                         '{string} is not allowed.')
        self.assertEqual(reason_of('weight_heading', Parameter.Type.NOT_SET, None),
                         'cannot undeclare a statically typed parameter')
        self.assertEqual(reason_of('weight_headings', Parameter.Type.DOUBLE, 1.0),
                         "parameter 'weight_headings' cannot be set because it was not declared")

    def test_of_every_rclcpp_node_are_there(self):
        listed = set(result_of(self.planner.list_parameters(), 'list_parameters').result.names)
        events = 'qos_overrides./parameter_events.publisher.'
        self.assertLessEqual({'use_sim_time', 'start_type_description_service', events + 'depth',
                              events + 'durability', events + 'history', events + 'reliability'}, listed)


if __name__ == '__main__':
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""The calls of nav2_simple_commander's BasicNavigator and of RViz's Nav2 panel, in their order, to a robot of ours
with bringup/systems/navigate.yaml. Run through with_rclpy."""
import math
import unittest

import rclpy_node
import robot
from rclpy_node import call, result_of, spin_until
from robot import start

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

try:
    from nav2_msgs.action import NavigateToPose
except ModuleNotFoundError:
    NavigateToPose = None

NEAR, FAR = (-3.2, -3.5), (2.0, -2.0)  # in the forest [m]


def setUpModule():
    global node
    if NavigateToPose is None:
        raise unittest.SkipTest('NOT TESTED: this Python has no nav2_msgs (tests/interop/build_peers build-peers)')
    node = rclpy_node.start_node()
    program = start('tandem', 'run', robot.SOURCE + '/bringup/systems/navigate.yaml', '--ros-args', '-p',
                    'dashboard:port:=0')
    unittest.addModuleCleanup(lambda: robot.stop(program))


class Navigator:
    """What BasicNavigator does, one method for each of its own of that name."""

    def __init__(self):
        self.pose = self.feedback = self.goal = self.result_future = None
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL,
                             reliability=ReliabilityPolicy.RELIABLE)
        self.client = ActionClient(node, NavigateToPose, 'navigate_to_pose')
        self.subscription = node.create_subscription(PoseWithCovarianceStamped, 'amcl_pose', self.on_pose, latched)

    def on_pose(self, message):
        self.pose = message.pose.pose.position

    def destroy(self):
        self.client.destroy()
        node.destroy_subscription(self.subscription)

    def state(self, name):
        client = node.create_client(GetState, f'{name}/get_state')
        try:
            return call(client, GetState.Request()).current_state.label
        finally:
            node.destroy_client(client)

    def waitUntilNav2Active(self):
        spin_until(lambda: self.state('amcl') == 'active', 'amcl is active')
        spin_until(lambda: self.pose, 'amcl_pose')
        spin_until(lambda: self.state('bt_navigator') == 'active', 'bt_navigator is active')

    def goToPose(self, place):
        spin_until(self.client.server_is_ready, 'navigate_to_pose')
        pose = PoseStamped()
        pose.header.frame_id = 'map'
        pose.header.stamp = node.get_clock().now().to_msg()
        pose.pose.position.x, pose.pose.position.y = place
        pose.pose.orientation.w = 1.0
        future = self.client.send_goal_async(NavigateToPose.Goal(pose=pose), self.on_feedback)
        self.goal = result_of(future, 'the goal is answered')
        if not self.goal.accepted:
            return False
        self.result_future = self.goal.get_result_async()
        return True

    def on_feedback(self, message):
        self.feedback = message.feedback

    def isTaskComplete(self):
        rclpy.spin_until_future_complete(node, self.result_future, timeout_sec=0.10)
        return self.result_future.result() is not None

    def cancelTask(self):
        result_of(self.goal.cancel_goal_async(), 'the answer to cancel')

    def getResult(self):
        spin_until(self.result_future.done, 'the result')
        return self.result_future.result()


class ANavigator(unittest.TestCase):
    def setUp(self):
        self.navigator = Navigator()
        self.addCleanup(self.navigator.destroy)

    def test_1_drives_to_a_pose(self):
        self.navigator.waitUntilNav2Active()
        self.assertTrue(self.navigator.goToPose(NEAR))
        distances = []

        def complete():
            done = self.navigator.isTaskComplete()
            if self.navigator.feedback:
                distances.append(self.navigator.feedback.distance_remaining)
            return done
        robot.until(complete, 'the task is complete', turn=0.0)
        result = self.navigator.getResult()
        self.assertEqual(result.status, GoalStatus.STATUS_SUCCEEDED)
        self.assertEqual(result.result.error_code, 0)
        self.assertGreater(distances[0], 0.5)
        self.assertLess(distances[-1], 0.5)
        self.assertEqual(self.navigator.feedback.number_of_recoveries, 0)
        self.assertLess(math.dist((self.navigator.pose.x, self.navigator.pose.y), NEAR), 0.3)

    def test_2_cancels_its_task(self):
        self.navigator.waitUntilNav2Active()
        self.assertTrue(self.navigator.goToPose(FAR))
        spin_until(lambda: self.navigator.feedback, 'feedback')
        self.navigator.cancelTask()
        self.assertEqual(self.navigator.getResult().status, GoalStatus.STATUS_CANCELED)

    def test_3_is_told_of_the_emergency_stop(self):
        self.navigator.waitUntilNav2Active()
        self.assertTrue(self.navigator.goToPose(FAR))
        publisher = node.create_publisher(Bool, '/e_stop', 1)
        spin_until(lambda: publisher.publish(Bool(data=True)) or self.navigator.isTaskComplete(), 'the task ends')
        result = self.navigator.getResult()
        self.assertEqual(result.status, GoalStatus.STATUS_ABORTED)
        self.assertEqual(result.result.error_code, 9000)
        self.assertEqual(result.result.error_msg, 'emergency stop')
        spin_until(lambda: self.navigator.state('bt_navigator') == 'inactive', 'bt_navigator is inactive')
        self.assertFalse(self.navigator.goToPose(NEAR))
        for kind, active in {'navigation': False, 'localization': True}.items():
            client = node.create_client(Trigger, f'/lifecycle_manager_{kind}/is_active')
            self.assertEqual(call(client, Trigger.Request()).success, active, kind)

    def test_4_has_the_type_hashes_of_rosidl(self):
        publisher = node.create_publisher(NavigateToPose.Impl.FeedbackMessage, '/hash', 1)
        [mine] = node.get_publishers_info_by_topic('/hash')
        topic = '/navigate_to_pose/_action/feedback'
        spin_until(lambda: node.get_publishers_info_by_topic(topic), topic)
        [ours] = node.get_publishers_info_by_topic(topic)
        self.assertEqual(str(ours.topic_type_hash), str(mine.topic_type_hash))
        node.destroy_publisher(publisher)


if __name__ == '__main__':
    unittest.main()

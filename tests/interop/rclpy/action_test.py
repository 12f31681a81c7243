# SPDX-License-Identifier: Apache-2.0
"""rclpy's ActionClient with our action server, and our action client with rclpy's ActionServer. Run through
with_rclpy."""
import subprocess
import unittest

import rclpy_node
import robot
from rclpy_node import result_of, spin_until
from robot import start, stop

import rclpy
from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.action import (ActionClient, ActionServer, CancelResponse, GoalResponse, get_action_names_and_types,
                          get_action_server_names_and_types_by_node)
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSPresetProfiles, qos_profile_action_status_default
from rclpy.task import Future
from service_msgs.msg import ServiceEventInfo
from test_msgs.action import Fibonacci

FIRST = [0, 1, 1, 2, 3, 5, 8, 13, 21, 34]
ENDLESS = 100  # the peers publish a number each 20 ms


def setUpModule():
    global node
    node = rclpy_node.start_node()


class OurServer(unittest.TestCase):
    def setUp(self):
        self.server = start('tests/action_peer', 'serve')
        self.addCleanup(lambda: stop(self.server) if self.server.poll() is None else None)
        self.client = ActionClient(node, Fibonacci, 'fibonacci')
        spin_until(self.client.server_is_ready, 'our server is seen')
        self.feedback = []

    def tearDown(self):
        if self.client:
            self.client.destroy()

    def send(self, order):
        goal = Fibonacci.Goal(order=order)
        future = self.client.send_goal_async(
            goal, feedback_callback=lambda message: self.feedback.append(list(message.feedback.sequence)))
        return result_of(future, f'the goal {order} is answered')

    def result(self, goal):
        return result_of(goal.get_result_async(), 'the result')

    def test_leads_a_goal_to_its_result_with_feedback(self):
        goal = self.send(9)
        self.assertTrue(goal.accepted)
        self.assertGreater(goal.stamp.sec, 0)
        result = self.result(goal)
        self.assertEqual(result.status, GoalStatus.STATUS_SUCCEEDED)
        self.assertEqual(list(result.result.sequence), FIRST)
        self.assertTrue(self.feedback)  # rclpy drops what arrives beside the result
        for numbers in self.feedback:
            self.assertEqual(numbers, FIRST[:len(numbers)])
        self.assertEqual(self.result(goal).result, result.result, 'a result is returned again')

    def test_rejects_and_aborts(self):
        self.assertFalse(self.send(-1).accepted)
        self.assertEqual(self.result(self.send(ENDLESS + 1)).status, GoalStatus.STATUS_ABORTED)

    def test_cancels_a_goal(self):
        goal = self.send(ENDLESS)
        spin_until(lambda: self.feedback, 'feedback')
        answer = result_of(goal.cancel_goal_async(), 'the answer to cancel')
        self.assertEqual(answer.return_code, CancelGoal.Response.ERROR_NONE)
        self.assertEqual([info.goal_id for info in answer.goals_canceling], [goal.goal_id])
        result = self.result(goal)
        self.assertEqual(result.status, GoalStatus.STATUS_CANCELED)
        self.assertLess(len(result.result.sequence), ENDLESS)
        answer = result_of(goal.cancel_goal_async(), 'the second answer')
        self.assertEqual(answer.return_code, CancelGoal.Response.ERROR_GOAL_TERMINATED)

    def test_goes_on_with_a_goal_that_it_does_not_let_be_cancelled(self):
        goal = self.send(13)
        answer = result_of(goal.cancel_goal_async(), 'the answer to cancel')
        self.assertEqual(answer.return_code, CancelGoal.Response.ERROR_REJECTED)
        self.assertEqual(answer.goals_canceling, [])
        self.assertEqual(self.result(goal).status, GoalStatus.STATUS_SUCCEEDED)

    def test_goes_on_without_its_client(self):
        states = {}
        self.addCleanup(node.destroy_subscription, node.create_subscription(
            GoalStatusArray, 'fibonacci/_action/status',
            lambda message: states.update({bytes(each.goal_info.goal_id.uuid): each.status
                                           for each in message.status_list}),
            qos_profile_action_status_default))
        goal = self.send(30)
        spin_until(lambda: self.feedback, 'feedback')
        self.client.destroy()
        self.client = None
        key = bytes(goal.goal_id.uuid)
        spin_until(lambda: states.get(key) == GoalStatus.STATUS_SUCCEEDED, 'the goal succeeds without its client')

    def test_tells_of_its_goals_as_rclcpp_tells(self):
        """What `ros2 action echo` shows."""
        parameters = AsyncParameterClient(node, 'fibonacci_server')
        self.assertTrue(parameters.wait_for_services(robot.PATIENCE))
        change = [Parameter('action_server_configure_introspection', Parameter.Type.STRING, 'contents')]
        self.assertTrue(result_of(parameters.set_parameters(change), 'introspection').results[0].successful)
        events = []
        topic = 'fibonacci/_action/send_goal/_service_event'
        self.addCleanup(node.destroy_subscription, node.create_subscription(
            Fibonacci.Impl.SendGoalService.Event, topic, events.append, QoSPresetProfiles.SERVICES_DEFAULT.value))
        spin_until(lambda: node.count_publishers(topic) == 1, 'the topic of events')
        [ours] = node.get_publishers_info_by_topic('/' + topic)
        [theirs] = node.get_subscriptions_info_by_topic('/' + topic)
        self.assertEqual(str(ours.topic_type_hash), str(theirs.topic_type_hash))
        goal = self.send(5)
        spin_until(lambda: len(events) >= 2, 'both events')
        received, sent = events
        self.assertEqual((received.info.event_type, sent.info.event_type),
                         (ServiceEventInfo.REQUEST_RECEIVED, ServiceEventInfo.RESPONSE_SENT))
        self.assertEqual(received.request[0].goal, Fibonacci.Goal(order=5))
        self.assertEqual(received.request[0].goal_id, goal.goal_id)
        self.assertTrue(sent.response[0].accepted)

    def test_is_missed_once_it_is_gone(self):
        goal = self.send(ENDLESS)
        self.assertTrue(goal.accepted)
        stop(self.server)
        spin_until(lambda: not self.client.server_is_ready(), 'our server is gone')

    def test_is_an_action_in_the_graph(self):
        action = ('/fibonacci', ['test_msgs/action/Fibonacci'])
        spin_until(lambda: action in get_action_names_and_types(node), 'the action')
        spin_until(lambda: 'fibonacci_server' in node.get_node_names(), 'the node')
        spin_until(lambda: action in get_action_server_names_and_types_by_node(node, 'fibonacci_server', '/'),
                   "the node's action")

    def test_has_the_qos_and_hashes_of_rclpys(self):
        theirs = ActionServer(node, Fibonacci, 'theirs', lambda goal: None)
        self.addCleanup(theirs.destroy)
        for part in ['feedback', 'status']:
            [mine] = node.get_publishers_info_by_topic(f'/theirs/_action/{part}')
            spin_until(lambda: node.get_publishers_info_by_topic(f'/fibonacci/_action/{part}'), part)
            [ours] = node.get_publishers_info_by_topic(f'/fibonacci/_action/{part}')
            self.assertEqual(str(ours.topic_type_hash), str(mine.topic_type_hash))
            self.assertEqual(ours.topic_type, mine.topic_type)
            for policy in ['reliability', 'durability', 'lifespan', 'deadline', 'liveliness']:
                self.assertEqual(getattr(ours.qos_profile, policy), getattr(mine.qos_profile, policy), policy)


class OurClient(unittest.TestCase):
    """The server steps its goals in a timer, as its execution shares the thread with everything else."""

    def setUp(self):
        self.goals = []
        self.server = ActionServer(
            node, Fibonacci, 'fibonacci', self.execute,
            goal_callback=lambda goal: GoalResponse.ACCEPT if goal.order >= 0 else GoalResponse.REJECT,
            cancel_callback=lambda goal: CancelResponse.ACCEPT)
        self.timer = node.create_timer(0.02, self.step)

    def tearDown(self):
        node.destroy_timer(self.timer)
        if self.server:
            self.server.destroy()

    async def execute(self, goal):
        done = Future()
        self.goals.append((goal, done, [0, 1]))
        return await done

    def step(self):
        for goal, done, numbers in list(self.goals):
            if goal.is_cancel_requested:
                self.end(goal.canceled, done, numbers)
            elif goal.request.order > ENDLESS:
                self.end(goal.abort, done, numbers)
            elif len(numbers) > goal.request.order:
                self.end(goal.succeed, done, numbers)
            else:
                numbers.append(numbers[-1] + numbers[-2])
                goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))

    def end(self, how, done, numbers):
        self.goals = [entry for entry in self.goals if entry[1] is not done]
        how()
        done.set_result(Fibonacci.Result(sequence=numbers))

    def run_client(self, *arguments):
        """Starts our client; returns it."""
        return subprocess.Popen([robot.BINARY + '/tests/action_peer', *map(str, arguments)],
                                stdout=subprocess.PIPE, text=True)

    def lines(self, *arguments):
        client = self.run_client(*arguments)
        spin_until(lambda: client.poll() is not None, f'our client ends: {arguments}')
        return client.communicate()[0].splitlines()

    def test_receives_feedback_and_the_result(self):
        lines = self.lines('send', 9)
        self.assertEqual(lines[0], 'accepted')
        self.assertEqual(lines[-1], 'succeeded ' + ' '.join(map(str, FIRST)))
        self.assertIn('feedback ' + ' '.join(map(str, FIRST)), lines)

    def test_is_told_that_a_goal_is_rejected_or_aborted(self):
        self.assertEqual(self.lines('send', -1), ['rejected'])
        self.assertEqual(self.lines('send', ENDLESS + 1)[-1], 'aborted 0 1')

    def test_cancels_a_goal(self):
        lines = self.lines('cancel', ENDLESS // 2)
        self.assertIn('cancel 0', lines)
        self.assertTrue(lines[-1].startswith('canceled 0 1 '), lines)

    def test_notices_that_the_server_is_gone(self):
        client = self.run_client('send', ENDLESS)
        spin_until(lambda: self.goals, 'the goal is executed')
        spin_until(lambda: len(self.goals[0][2]) > 4, 'the goal goes on')
        self.goals = []
        self.server.destroy()
        self.server = None
        spin_until(lambda: client.poll() is not None, 'our client ends without a server')
        self.assertEqual(client.communicate()[0].splitlines()[-1], 'unknown ')


if __name__ == '__main__':
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""An rclpy node beside a robot of ours, and what tests do with it."""
import unittest

import robot
from robot import start, stop, until

DOMAIN = robot.take_domain()

import rclpy  # noqa: E402  reads ROS_DOMAIN_ID

NODES = {'/map_server', '/joystick', '/teleop', '/obstacle_extractor', '/local_planner', '/arbitration',
         '/safety_filter', '/haptics', '/dashboard', '/diff_drive_sim'}
SYSTEM = robot.SOURCE + '/bringup/systems/teleop.yaml'
CONTAINER = '/tandem_container'


def start_node():
    """Starts the node alone, until the end of the test module."""
    global node
    unittest.addModuleCleanup(end, [])
    rclpy.init()
    node = rclpy.create_node('beside')
    return node


def start_robot():
    """Starts a robot, an empty container and the node, until the end of the test module."""
    global node
    programs = [start('tandem', 'run', SYSTEM, '--ros-args', '-p', 'dashboard:port:=0',
                      '-p', 'arbitration:policy:=manual'),
                start('tandem', 'container')]
    unittest.addModuleCleanup(end, programs)
    rclpy.init()
    node = rclpy.create_node('beside')
    until(lambda: NODES | {CONTAINER} <= names(), 'our nodes are seen')


def end(programs):
    node.destroy_node()
    rclpy.shutdown()
    results = [stop(program) for program in programs]
    if any(results):
        raise AssertionError(f'our programs ended with {results}')


def names():
    """The full names of all nodes in the graph."""
    return {(ns.rstrip('/') + '/' + name) for name, ns in node.get_node_names_and_namespaces()}


def spin_until(condition, what):
    def turn():
        rclpy.spin_once(node, timeout_sec=0.02)
        return condition()
    return until(turn, what)


def result_of(future, what):
    spin_until(future.done, what)
    return future.result()


def call(client, request):
    """Sends one request and returns the answer: discovery must not lose it."""
    if not client.wait_for_service(robot.PATIENCE):
        raise AssertionError(f'{client.srv_name} is not there')
    return result_of(client.call_async(request), client.srv_name)


class Received:
    """The messages of a topic."""

    def __init__(self, kind, topic, qos):
        self.messages = []
        self.subscription = node.create_subscription(kind, topic, self.messages.append, qos)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        node.destroy_subscription(self.subscription)

    def next(self, matches=lambda message: True):
        """The first matching message from now on."""
        del self.messages[:]
        return self.any(matches)

    def any(self, matches=lambda message: True):
        """The first matching message, received already or later."""
        spin_until(lambda: any(map(matches, self.messages)), self.subscription.topic_name)
        return next(filter(matches, self.messages))

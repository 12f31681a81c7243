# SPDX-License-Identifier: Apache-2.0
"""A publisher of rclpy whose sequence numbers are far ahead, and a reader of ours that joins it or that was
stopped for a while: it receives the newest messages, and its network guard drops nothing. Run through with_rclpy;
TANDEM_FAR_AHEAD sets how far (default: 10⁵)."""
import ctypes
import os
import signal
import subprocess
import time
import unittest

import robot
from robot import until

DOMAIN = robot.take_domain()

import rclpy  # noqa: E402  reads ROS_DOMAIN_ID
from geometry_msgs.msg import Twist  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402

FAR_AHEAD = int(os.environ.get('TANDEM_FAR_AHEAD', 10**5))
OUTAGE = 8.0   # [s], less than the lease after which a reader is forgotten
PERIOD = 0.01  # [s]


def publish_many(publisher, count):
    """Calls rcl_publish itself, because rclpy would take five times as long."""
    rcl_publish = ctypes.CDLL('librcl.so').rcl_publish
    rcl_publish.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    message = ctypes.create_string_buffer(48)  # six zeros
    with publisher.handle:
        handle = publisher.handle.pointer
        for _ in range(count):
            rcl_publish(handle, message, None)


class AReaderOfOurs(unittest.TestCase):
    def setUp(self):
        rclpy.init()
        self.addCleanup(rclpy.shutdown)
        self.node = rclpy.create_node('far_ahead')
        self.addCleanup(self.node.destroy_node)
        self.ping = self.node.create_publisher(Twist, '/ping', 10)
        self.pongs = 0
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(Twist, '/pong', self.count, latched)

    def count(self, _):
        self.pongs += 1

    def start_peer(self):
        peer = subprocess.Popen([robot.BINARY + '/tests/peer', 'echo'], stderr=subprocess.PIPE, text=True)
        self.addCleanup(peer.stderr.close)
        self.addCleanup(peer.kill)
        return peer

    def until_answered(self):
        wanted = self.pongs + 20

        def answered():
            self.ping.publish(Twist())
            rclpy.spin_once(self.node, timeout_sec=PERIOD)
            return self.pongs >= wanted
        until(answered, 'the reader answers', turn=PERIOD)

    def assert_nothing_dropped(self, peer):
        time.sleep(2.0)  # the guard reports within a second of its first drop
        peer.send_signal(signal.SIGTERM)
        _, log = peer.communicate(timeout=robot.PATIENCE)
        self.assertEqual(peer.returncode, 0, log)
        self.assertNotIn('malformed or too frequent', log)

    def test_that_joins_far_ahead_receives_the_newest(self):
        publish_many(self.ping, FAR_AHEAD)
        peer = self.start_peer()
        self.until_answered()
        self.assert_nothing_dropped(peer)

    def test_that_was_stopped_receives_the_newest(self):
        peer = self.start_peer()
        self.until_answered()
        peer.send_signal(signal.SIGSTOP)
        end = time.monotonic() + OUTAGE
        while time.monotonic() < end:
            self.ping.publish(Twist())
            time.sleep(PERIOD)
        peer.send_signal(signal.SIGCONT)
        self.until_answered()
        self.assert_nothing_dropped(peer)


if __name__ == '__main__':
    unittest.main()

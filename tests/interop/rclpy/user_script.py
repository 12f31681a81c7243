# SPDX-License-Identifier: Apache-2.0
"""A user's first try: publishes /cmd_vel_user at 20 Hz until the robot drives. Exit 0 once it does."""
import time

import rclpy
from geometry_msgs.msg import Twist

rclpy.init()
node = rclpy.create_node('first_try')
speeds = []
node.create_subscription(Twist, '/cmd_vel', lambda msg: speeds.append(msg.linear.x), 10)
user = node.create_publisher(Twist, '/cmd_vel_user', 10)
ahead = Twist()
ahead.linear.x = 0.3
node.create_timer(0.05, lambda: user.publish(ahead))
end = time.monotonic() + 60.0  # [s]
while sum(v > 0.2 for v in speeds) < 20:
    assert time.monotonic() < end, f'the robot does not drive: {speeds[-5:]}'
    rclpy.spin_once(node, timeout_sec=0.1)

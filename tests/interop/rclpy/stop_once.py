# SPDX-License-Identifier: Apache-2.0
"""The emergency stop pressed once by programs that leave, received by our robot and, beside it, by a reliable
rclpy subscriber of depth 10.

    stop_once.py TRIES    so many programs of each kind of sender; exit 1 if the robot receives fewer of one
                          kind than the subscriber, by more than chance

Each program sends as soon as its publisher is matched with anybody and leaves 0.1 s later, so what
arrives depends on how soon robot and subscriber are discovered. Started through with_rclpy.
"""
import math
import os
import signal
import subprocess
import sys
import time

import rclpy
import rclpy.logging
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

import robot

RELIABLE, BEST_EFFORT = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL
SENDERS = {'volatile reliable': (RELIABLE, VOLATILE),
           'volatile best effort': (BEST_EFFORT, VOLATILE),
           'latched': (RELIABLE, LATCHED)}
KEEP_ALIVE = 0.1  # [s] from the first match to the end, as in `ros2 topic pub -1`
SIGNIFICANT = 0.001  # probability below which a result is no longer taken for chance
LATE = 1.0        # [s] after the program's end in which its message may still arrive


def press(sender):
    """The whole life of a program that presses the stop once."""
    reliability, durability = SENDERS[sender]
    rclpy.init()
    node = rclpy.create_node('button')
    publisher = node.create_publisher(
        Bool, '/e_stop', QoSProfile(depth=1, reliability=reliability, durability=durability))
    robot.until(publisher.get_subscription_count, 'somebody listens', turn=0.001)
    publisher.publish(Bool(data=True))
    time.sleep(KEEP_ALIVE)
    node.destroy_node()
    rclpy.shutdown()


def press_in_new_processes():
    """Presses once for each line of standard input and answers with a line when the program has left.
    The processes are forks of one that has loaded rclpy but not started it."""
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            press(line.strip())
            os._exit(0)
        os.waitpid(child, 0)
        print('left', flush=True)


class Bystander:
    """The subscriber beside the robot; reads from /rosout what the robot does."""

    def __init__(self):
        self.node = rclpy.create_node('bystander')
        self.heard = self.robot_stopped = False
        self.node.create_subscription(Bool, '/e_stop', self.on_stop, 10)
        self.node.create_subscription(Log, '/rosout', self.on_log,
                                      QoSProfile(depth=1000, durability=LATCHED))
        self.release = self.node.create_publisher(Bool, '/e_stop', QoSProfile(depth=1, durability=LATCHED))
        self.client = self.node.create_client(Trigger, '/arbitration/release_emergency_stop')

    def on_stop(self, message):
        self.heard = self.heard or message.data

    def on_log(self, message):
        if message.name == 'arbitration' and message.msg == 'emergency stop':
            self.robot_stopped = True

    def spin_until(self, condition, timeout):
        end = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > end:
                return False
            rclpy.spin_once(self.node, timeout_sec=0.01)
        return True

    def let_go(self):
        """Releases the stop; the `false` and the request travel on different topics."""
        self.release.publish(Bool(data=False))
        end = time.monotonic() + robot.PATIENCE
        while time.monotonic() < end:
            answer = self.client.call_async(Trigger.Request())
            self.spin_until(answer.done, robot.PATIENCE)
            if answer.done() and answer.result().success:
                return
        raise AssertionError('the emergency stop is not released')


def run(tries):
    presser = subprocess.Popen([sys.executable, __file__, 'presser'], stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
    system = subprocess.Popen(
        [robot.BINARY + '/tandem', 'run', robot.SOURCE + '/bringup/systems/teleop.yaml', '--ros-args',
         '-p', 'dashboard:port:=0'], stderr=subprocess.DEVNULL)
    rclpy.init()
    rclpy.logging.set_logger_level('bystander', rclpy.logging.LoggingSeverity.ERROR)  # no warnings
    try:
        return compare(Bystander(), presser, tries)
    finally:
        presser.stdin.close()
        presser.wait()
        system.send_signal(signal.SIGINT)
        system.wait()


def compare(beside, presser, tries):
    if not beside.client.wait_for_service(robot.PATIENCE):
        raise AssertionError('the robot is not there')
    return any([is_worse(beside, presser, sender, tries) for sender in SENDERS])


def chance_of(wins, tries):
    """The probability of at least `wins` heads in `tries` tosses of a fair coin."""
    return sum(math.comb(tries, heads) for heads in range(wins, tries + 1)) / 2 ** tries


def is_worse(beside, presser, sender, tries):
    """Sign test over the tries in which only one of the two heard the stop: on a busy machine chance decides
    many of them. A robot that comes off worse gets two more rounds, and all of them count."""
    ours = theirs = alone = robot_alone = 0
    for rounds in range(1, 4):
        for _ in range(tries):
            beside.heard = beside.robot_stopped = False
            presser.stdin.write(sender + '\n')
            presser.stdin.flush()
            presser.stdout.readline()
            beside.spin_until(lambda: beside.robot_stopped and beside.heard, LATE)
            ours += beside.robot_stopped
            theirs += beside.heard
            alone += beside.heard and not beside.robot_stopped
            robot_alone += beside.robot_stopped and not beside.heard
            beside.let_go()
        if ours >= theirs:
            break
    chance = chance_of(alone, alone + robot_alone)
    print(f'{sender}: heard by the robot {ours}, by the subscriber {theirs} of {rounds * tries}; '
          f'by the subscriber alone {alone}, probability of that many {chance:.2g}', flush=True)
    return chance < SIGNIFICANT


if __name__ == '__main__':
    if sys.argv[1:] == ['presser']:
        press_in_new_processes()
    elif len(sys.argv) == 2 and sys.argv[1].isdigit():
        domain = robot.take_domain()
        sys.exit(run(int(sys.argv[1])))
    else:
        sys.exit(__doc__)

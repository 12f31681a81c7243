# SPDX-License-Identifier: Apache-2.0
"""ros2 bag beside a robot of ours, and our recordings and rosbag2's in each other's hands. Started by
beside_ros2."""
import contextlib
import json
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import unittest

import robot
from robot import ros2, says, start, stop

DOMAIN = robot.take_domain()

SCENARIO = robot.SOURCE + '/bringup/scenarios/forest_task2.yaml'
SYSTEM = robot.SOURCE + '/bringup/systems/forest.yaml'
OF_ALL_ROBOTS = ['/odom', '/tf', '/clock', '/cmd_vel', '/cmd_vel_user', '/joy', '/map', '/octomap_binary', '/obstacles',
                 '/arbitration/status', '/planner/status', '/safety_filter/status', '/rosout']


def setUpModule():
    global folder, log, storage  # storage: the one that this ROS 2 has
    if 'record' not in ros2('bag', '--help'):
        raise unittest.SkipTest('NOT TESTED: this ROS 2 has no `ros2 bag`')
    folder = pathlib.Path(tempfile.mkdtemp())
    unittest.addModuleCleanup(shutil.rmtree, folder)
    unittest.addModuleCleanup(ros2, 'daemon', 'stop')  # some commands start the daemon
    driven = start('tandem', 'run', SYSTEM)
    try:
        log = recorded_by_rosbag2()
        storage = re.search(r'storage_identifier: (\w+)', (folder / 'theirs' / 'metadata.yaml').read_text())[1]
        record_with_ours()
    finally:
        assert stop(driven) == 0


def recorded_by_rosbag2():
    """What it says meanwhile."""
    with open(folder / 'log', 'w+', encoding='utf-8') as said:
        recorder = subprocess.Popen(['ros2', 'bag', 'record', '-a', '-o', folder / 'theirs'], stdout=said,
                                    stderr=subprocess.STDOUT)
        until_driving()
        interrupt(recorder)
        said.seek(0)
        return said.read()


def record_with_ours():
    recorder = start('tandem', 'record', '--storage', storage, '-o', str(folder / 'ours'))
    until_driving()
    assert interrupt(recorder) == 0


def until_driving():
    says('semi_axis_a', 'topic', 'echo', '--once', '/obstacles', ask=ros2)
    says('linear:\n  x: 0\\.[1-9]', 'topic', 'echo', '--once', '/cmd_vel', ask=ros2)


def interrupt(process):
    process.send_signal(signal.SIGINT)
    return process.wait(robot.PATIENCE)


@contextlib.contextmanager
def played(bag):
    """By rosbag2, again and again."""
    player = subprocess.Popen(['ros2', 'bag', 'play', bag, '--loop', '--disable-keyboard-controls'])
    try:
        yield
    finally:
        interrupt(player)


def counts_of(bag):
    info = ros2('bag', 'info', str(bag))
    return {topic: int(count) for topic, count in
            re.findall(r'Topic: (\S+) \| Type: \S+ \| Count: (\d+)', info)}


class Theirs(unittest.TestCase):
    def test_records_every_topic_and_complains_of_none(self):
        self.assertNotRegex(log, '(?i)unknown|Only topics with|error|incompatible')
        counts = counts_of(folder / 'theirs')
        self.assertEqual([topic for topic in OF_ALL_ROBOTS if not counts.get(topic)], [], log)

    def test_knows_our_types(self):
        self.assertRegex(ros2('bag', 'info', str(folder / 'theirs')),
                         r'Topic: /obstacles \| Type: tandem_msgs/msg/ObstacleArray')

    def test_is_measured_by_ours(self):
        measures = folder / 'measures.json'
        measured = start('tandem', 'metrics', str(folder / 'theirs'), '--scenario', SCENARIO, '--json', str(measures))
        self.assertEqual(measured.wait(robot.PATIENCE), 0)
        self.assertGreater(json.loads(measures.read_text())['path_length_m'], 0.0)

    def test_is_played_by_ours(self):
        player = start('tandem', 'play', str(folder / 'theirs'), '--wait', '60', '--topics', '/obstacles')
        says('semi_axis_a', 'topic', 'echo', '--once', '/obstacles', ask=ros2)
        stop(player)

    def test_is_played_beside_ours(self):
        heard = start('tandem', 'record', '--storage', storage, '-o', str(folder / 'again'), '/obstacles', '/odom')
        with played(folder / 'theirs'):
            says('semi_axis_a', 'topic', 'echo', '--once', '/obstacles', ask=ros2)
            says('frame_id: odom', 'topic', 'echo', '--once', '/odom', ask=ros2)
        self.assertEqual(interrupt(heard), 0)
        self.assertEqual({topic for topic, count in counts_of(folder / 'again').items() if count},
                         {'/obstacles', '/odom'})


class Ours(unittest.TestCase):
    def test_is_told_of_by_theirs(self):
        counts = counts_of(folder / 'ours')
        self.assertEqual([topic for topic in OF_ALL_ROBOTS if not counts.get(topic)], [])

    def test_is_played_by_theirs(self):
        with played(folder / 'ours'):
            says('semi_axis_a', 'topic', 'echo', '--once', '/obstacles', ask=ros2)
            says('reason: ', 'topic', 'echo', '--once', '/arbitration/status', ask=ros2)


if __name__ == '__main__':
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""ros2 launch tandem tandem.launch.py system:=teleop

Runs a system, one process for each component: one of Tandem's by name, or a file. Needs no other ROS package than
launch: the program is found beside this installed file.
"""
import pathlib

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

PREFIX = pathlib.Path(__file__).resolve().parents[3]  # <prefix>/share/tandem/launch/tandem.launch.py


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument('system', default_value='teleop',
                              description="A system file, or the name of one of Tandem's"),
        ExecuteProcess(cmd=[str(PREFIX / 'bin' / 'tandem'), 'run', LaunchConfiguration('system'), '--separate'],
                       output='screen'),
    ])

// SPDX-License-Identifier: Apache-2.0
// The ROS 2 messages that the page itself sends.
const HEADER = `
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;

export const DEFINITIONS: Record<string, string> = {
  "sensor_msgs/msg/Joy": `std_msgs/Header header\nfloat32[] axes\nint32[] buttons\n${HEADER}`,
  "geometry_msgs/msg/PoseStamped": `std_msgs/Header header
geometry_msgs/Pose pose
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
${HEADER}`,
  "std_msgs/msg/Bool": "bool data\n",
};

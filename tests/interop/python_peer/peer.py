# SPDX-License-Identifier: Apache-2.0
"""A peer that shares no code with Tandem: Python on Cyclone DDS, without ROS.

    peer.py drive    publishes /cmd_vel_user and watches /cmd_vel until the robot is told so
    peer.py lead     the same where a planner drives; then it is silent until the robot is told to stand
    peer.py graph    reads ros_discovery_info until it names the robot's nodes
    peer.py bag DIR  reads a recording with the `rosbags` library

Exit 0 once what was to be seen was seen. The domain is ROS_DOMAIN_ID's.
"""
import math
import os
import sys
import time
from dataclasses import dataclass, field

TIMEOUT = 60.0  # [s]

LOOPBACK = """<CycloneDDS><Domain><General><Interfaces>
<NetworkInterface name="lo" multicast="true"/></Interfaces></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>31</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""


def domain_id():
    return int(os.environ.get("ROS_DOMAIN_ID", "0"))


def types():
    """The messages, field for field, under the names that ROS 2 gives them on DDS."""
    from cyclonedds.idl import IdlStruct
    from cyclonedds.idl.annotations import final
    from cyclonedds.idl.types import array, bounded_str, float64, sequence, uint8

    def ros(name):
        package, kind = name.split("/")
        return f"{package}.msg.dds_.{kind}_"

    @dataclass
    @final
    class Vector3(IdlStruct, typename=ros("geometry_msgs/Vector3")):
        x: float64 = 0.0
        y: float64 = 0.0
        z: float64 = 0.0

    @dataclass
    @final
    class Twist(IdlStruct, typename=ros("geometry_msgs/Twist")):
        linear: Vector3 = field(default_factory=Vector3)
        angular: Vector3 = field(default_factory=Vector3)

    @dataclass
    @final
    class Gid(IdlStruct, typename=ros("rmw_dds_common/Gid")):
        data: array[uint8, 16]

    @dataclass
    @final
    class NodeEntitiesInfo(IdlStruct, typename=ros("rmw_dds_common/NodeEntitiesInfo")):
        node_namespace: bounded_str[256]
        node_name: bounded_str[256]
        reader_gid_seq: sequence[Gid]
        writer_gid_seq: sequence[Gid]

    @dataclass
    @final
    class ParticipantEntitiesInfo(IdlStruct, typename=ros("rmw_dds_common/ParticipantEntitiesInfo")):
        gid: Gid
        node_entities_info_seq: sequence[NodeEntitiesInfo]

    return Twist, ParticipantEntitiesInfo


def participant():
    from cyclonedds.domain import Domain, DomainParticipant

    domain = Domain(domain_id(), LOOPBACK)
    return domain, DomainParticipant(domain_id())


def qos(*policies):
    from cyclonedds.core import Policy, Qos

    return Qos(Policy.DataRepresentation(use_cdrv0_representation=True), *policies)


def user_and_command():
    """A writer of /cmd_vel_user, a reader of /cmd_vel, and what they live in."""
    from cyclonedds.core import Policy
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    Twist, _ = types()
    domain, me = participant()
    reliable = qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
    user = DataWriter(me, Topic(me, "rt/cmd_vel_user", Twist, qos=reliable), qos=reliable)
    command = DataReader(me, Topic(me, "rt/cmd_vel", Twist, qos=reliable), qos=reliable)
    twist = Twist()
    twist.linear.x = 0.3
    return domain, user, command, twist


def drive(obeys=lambda got: math.isclose(got.linear.x, 0.3)):
    domain, user, command, twist = user_and_command()
    obeyed = 0
    end = time.monotonic() + TIMEOUT
    while time.monotonic() < end and obeyed < 20:
        user.write(twist)
        obeyed += sum(map(obeys, command.take(100)))
        time.sleep(0.05)  # the period of a joystick
    assert obeyed >= 20, f"the robot was told our 0.3 m/s {obeyed} times only"
    return domain, command, end


def lead():
    _domain, command, end = drive(lambda got: got.linear.x > 0.2)
    while not any(got.linear.x == 0.0 for got in command.take(100)):
        assert time.monotonic() < end, "the robot drives on without us"
        time.sleep(0.01)


def graph():
    from cyclonedds.core import Policy
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    _, ParticipantEntitiesInfo = types()
    _domain, me = participant()
    latched = qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal,
                  Policy.History.KeepAll)
    reader = DataReader(
        me, Topic(me, "ros_discovery_info", ParticipantEntitiesInfo, qos=latched), qos=latched)
    wanted = {"arbitration", "safety_filter", "diff_drive_sim", "local_planner"}
    names = set()
    for info in reader.take_iter(timeout=duration(seconds=TIMEOUT)):
        names |= {node.node_name for node in info.node_entities_info_seq}
        if wanted <= names:
            break
    assert wanted <= names, f"nodes seen: {sorted(names)}"


def bag(folder):
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Reader(folder) as reader:
        values = [store.deserialize_cdr(raw, connection.msgtype).data
                  for connection, _, raw in reader.messages() if connection.topic == "/numbers"]
        assert reader.message_count >= len(values)
    assert values == [float(i) for i in range(len(values))] and len(values) >= 10, values


if __name__ == "__main__":
    if sys.argv[1:2] == ["drive"]:
        drive()
    elif sys.argv[1:2] == ["lead"]:
        lead()
    elif sys.argv[1:2] == ["graph"]:
        graph()
    elif sys.argv[1:2] == ["bag"] and len(sys.argv) == 3:
        bag(sys.argv[2])
    else:
        sys.exit(__doc__)

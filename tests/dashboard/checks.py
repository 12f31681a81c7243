# SPDX-License-Identifier: Apache-2.0
"""Runs a check with a third-party WebSocket client against our robot: checks.py TANDEM SYSTEM CHECK."""

import json
import os
import pathlib
import random
import re
import resource
import socket
import sys
import threading
import time

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from client import LONG, PROTOCOL, Client, Robot, joy, push, string

DEFINITION = pathlib.Path(__file__).parents[2] / "idl/tandem_msgs/msg/ReasonCode.msg"
REASON_CODES = {name: int(value) for name, value in re.findall(r"^uint8 (\w+)=(\d+)$", DEFINITION.read_text(), re.M)}
SANITIZED = "TANDEM_SANITIZED" in os.environ


def drive(robot):
    client = Client(robot.port)
    assert client.socket.subprotocol == PROTOCOL
    assert client.info["op"] == "serverInfo" and "clientPublish" in client.info["capabilities"]
    for topic in ("/odom", "/map", "/plan", "/arbitration/status"):
        client.subscribe(topic)
    client.until(lambda: client.newest("/odom") and client.newest("/map"))
    assert client.newest("/map").info.resolution > 0.0
    client.advertise(1, "/joy", "sensor_msgs/msg/Joy")
    client.until(lambda: client.newest("/odom").twist.twist.linear.x > 0.2,
                 beat=push(client, 1.0, 0.0))
    client.until(lambda: len(client.newest("/plan").poses) > 1)
    client.until(lambda: abs(client.newest("/odom").twist.twist.linear.x) < 0.01)  # silence stops the robot
    assert b"policy is now manual" in client.call("/arbitration/set_policy", string("manual"))
    client.until(lambda: client.newest("/arbitration/status").policy == "manual")
    client.say(op="getParameters", parameterNames=["/teleop.leash"], id="a")
    client.until(lambda: client.parameters.get("/teleop.leash") == 1.2)
    client.say(op="subscribeParameterUpdates", parameterNames=["/teleop.leash"])
    client.say(op="setParameters", parameters=[{"name": "/teleop.leash", "value": 2, "type": "float64"}])
    client.until(lambda: client.parameters["/teleop.leash"] == 2.0)
    client.say(op="setParameters", parameters=[{"name": "/teleop.leash", "value": -1.0}])
    client.until(lambda: any("leash" in status for status in client.statuses))
    client.say(op="getParameters", parameterNames=[])
    client.until(lambda: "/local_planner.weight_heading" in client.parameters)


def sdk(robot):
    """A client of Foxglove's SDK, which knows the protocol by its newer name only."""
    with connect(f"ws://127.0.0.1:{robot.port}/", subprotocols=["foxglove.sdk.v1"], max_size=None) as client:
        assert client.subprotocol == "foxglove.sdk.v1"
        assert json.loads(client.recv(LONG))["op"] == "serverInfo"


def seat(robot):
    first, second = Client(robot.port), Client(robot.port)
    for client in (first, second):
        client.subscribe("/odom")
        client.advertise(1, "/joy", "sensor_msgs/msg/Joy")
    first.until(lambda: first.newest("/odom") and first.newest("/odom").twist.twist.linear.x > 0.2,
                beat=push(first, 1.0, 0.0))
    second.publish(1, joy(-1.0, 0.0, 1))
    second.until(lambda: "someone else is driving" in second.statuses)
    assert second.call("/arbitration/set_policy", string("manual")) == "someone else is driving"
    second.call("/dashboard/take_wheel", b"\0\1\0\0\0")
    first.until(lambda: "someone else has taken the wheel" in first.statuses)
    first.publish(1, joy(1.0, 0.0, 1))
    first.until(lambda: "someone else is driving" in first.statuses)
    second.publish(1, joy(0.0, 0.0, 1))
    second.socket.close()
    let_go = time.monotonic() + 5.5  # the preempted client must release for seat_timeout
    first.until(lambda: time.monotonic() > let_go)
    assert abs(first.newest("/odom").twist.twist.linear.x) < 0.02
    first.until(lambda: first.newest("/odom").twist.twist.linear.x > 0.2,
                beat=push(first, 1.0, 0.0))  # the driver lock is free again


def leave(robot):
    """A connection that ends while the stick is held: reconnecting with the stick held moves nothing."""
    gone = Client(robot.port)
    gone.subscribe("/odom")
    gone.advertise(1, "/joy", "sensor_msgs/msg/Joy")
    gone.until(lambda: gone.newest("/odom") and gone.newest("/odom").twist.twist.linear.x > 0.2,
               beat=push(gone, 1.0, 0.0))
    gone.socket.close()
    back = Client(robot.port)
    for topic in ("/odom", "/arbitration/status"):
        back.subscribe(topic)
    back.advertise(1, "/joy", "sensor_msgs/msg/Joy")
    held = lambda: back.publish(1, joy(1.0, 0.0, 1))
    speed = lambda: abs(back.newest("/odom").twist.twist.linear.x)
    back.until(lambda: back.newest("/odom") and speed() < 0.01, beat=held)
    refused = lambda: back.newest("/arbitration/status").reason_code.value == REASON_CODES["STICK_MOVED"]
    back.until(lambda: back.newest("/arbitration/status") and refused(), beat=held)
    end = time.monotonic() + 2.0
    back.until(lambda: time.monotonic() > end or speed() > 0.01, beat=held)
    assert speed() < 0.01, "it drives on by itself"
    back.until(lambda: speed() > 0.2, beat=push(back, 1.0, 0.0))


def trial(robot):
    """A trial of the user test is measured on the robot, for the client that drives."""
    client, other = Client(robot.port), Client(robot.port)
    for c in (client, other):
        c.subscribe("/odom")
        c.subscribe("/dashboard/trial")
        c.advertise(1, "/joy", "sensor_msgs/msg/Joy")
        c.advertise(2, "/dashboard/begin_trial", "tandem.TrialRequest", encoding="json")
    drives = push(client, 1.0, 0.0)
    client.until(lambda: client.newest("/odom") and client.newest("/odom").twist.twist.linear.x > 0.2, beat=drives)
    asked = {"id": 5, "method": "manual", "task": 1, "practice": False, "allowed": 2}
    begin = lambda c, what: c.publish(2, json.dumps(what).encode())
    begin(client, {**asked, "allowed": -1})
    client.until(lambda: any("allowed is outside" in status for status in client.statuses), beat=drives)
    begin(other, {**asked, "id": 6})
    other.until(lambda: "someone else is driving" in other.statuses, beat=drives)
    begin(client, asked)
    client.until(lambda: "trial" in (client.newest("/dashboard/trial") or {}), beat=drives)
    told = client.messages["/dashboard/trial"]
    assert {state["id"] for state in told} == {5}
    assert [state["time"] for state in told] == sorted(state["time"] for state in told)
    came_to = told[-1]["trial"]
    print(came_to, len(told))
    assert all(came_to[key] == asked[key] for key in ("method", "task", "practice", "allowed"))
    assert came_to["time"] == 2.0 and came_to["collisions"] == 0 and not came_to["reached"]
    assert 0.1 < came_to["path_length"] < 3.0 and 0.0 < came_to["min_clearance"] <= 1.0
    late = Client(robot.port)  # a page that connects later; watching needs no lock
    late.subscribe("/dashboard/trial")
    late.until(lambda: late.newest("/dashboard/trial"))
    assert late.newest("/dashboard/trial") == told[-1]


def ask(port, host):
    """The first line of the answer to a WebSocket request for that host name."""
    with socket.create_connection(("127.0.0.1", port), LONG) as raw:
        raw.sendall((f"GET / HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                     f"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
                     f"Sec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n").encode())
        return raw.makefile("rb").readline().decode()


def door(robot):
    try:
        Client(robot.port, origin="https://elsewhere.example")
        raise AssertionError("a page of another site came in")
    except InvalidStatus as refused:
        assert refused.response.status_code == 403
    # The DNS of another site may resolve its name to this address (DNS rebinding).
    assert ask(robot.port, "evil.example").startswith("HTTP/1.1 403")
    assert ask(robot.port, f"localhost:{robot.port}").startswith("HTTP/1.1 101")
    client = Client(robot.port, origin=f"http://127.0.0.1:{robot.port}")
    client.advertise(4, "/\x1b[2J\nforged\u00e9", "a/msg/B")
    client.until(lambda: any("forged" in line for line in robot.lines), beat=lambda: client.publish(9, b""))
    assert any("/?[2J?forged??" in line for line in robot.lines), "a client writes to the terminal"
    client.advertise(1, "/cmd_vel", "geometry_msgs/msg/Twist")
    client.advertise(2, "/joy", "std_msgs/msg/Bool")
    client.advertise(5, "/goal_pose", "geometry_msgs/PoseStamped")  # as Lichtblick writes it
    client.publish(3, b"")
    for complaint in ("web clients may not publish /cmd_vel", "/joy takes sensor_msgs/msg/Joy in cdr",
                      "a message on a channel that was not advertised"):
        client.until(lambda: complaint in client.statuses)
    assert not any("/goal_pose" in status for status in client.statuses)


def knock(port, times):
    """Opens more connections than max_clients, as many at once as the machine allows, all silent."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, times + 200), most))
    sockets = []
    for _ in range(times):
        try:
            sockets.append(socket.create_connection(("127.0.0.1", port), 1.0))
        except OSError:  # out of files or ports
            while sockets:
                sockets.pop().close()
    for one in sockets:
        one.close()


def soon(condition):
    """Under a sanitizer the planner may stall for a moment."""
    end = time.monotonic() + 3.0
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def hostile(robot):
    driver = Client(robot.port)
    driver.subscribe("/odom")
    driver.advertise(1, "/joy", "sensor_msgs/msg/Joy")
    rest = threading.Event()
    drives = push(driver, 0.0, 0.5)
    holds = threading.Thread(target=lambda: driver.until(rest.is_set, beat=drives), daemon=True)
    turns = lambda: driver.newest("/odom").twist.twist.angular.z > 0.2
    driver.until(lambda: driver.newest("/odom") and turns(), beat=drives)
    holds.start()
    before = robot.memory()
    chance = random.Random(7)
    for _ in range(20):
        client = Client(robot.port, close_timeout=0.1)
        try:
            for _ in range(50):
                garbage = chance.randbytes(chance.randrange(200))
                client.socket.send(chance.choice([garbage, garbage.decode("latin1")]))
        except ConnectionClosed:
            pass
        client.socket.close()
        assert soon(turns), "garbage disturbed the robot"
    client = Client(robot.port, close_timeout=0.1)
    client.socket.send(b"\1" * 70_000)  # larger than max_message
    expect_closed(client)
    client = Client(robot.port, close_timeout=0.1)  # faster than max_rate
    try:
        for _ in range(5000):
            client.socket.send(b"\0")
    except ConnectionClosed:
        pass
    expect_closed(client)
    knock(robot.port, 10_000)
    assert holds.is_alive(), "the driver lost its connection"
    rest.set()
    holds.join()
    count = len(driver.messages["/odom"])
    driver.until(lambda: len(driver.messages["/odom"]) >= count + 20, beat=drives)
    assert soon(turns), "the robot was disturbed"
    stamps = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in driver.messages["/odom"]]
    gap = max(after - at for at, after in zip(stamps, stamps[1:]))
    print(f"{gap:.3f} s at most between two odometries")
    assert SANITIZED or gap < 1.0, "the robot's loop stood"
    print(f"{before:.0f} MB before, {robot.memory():.0f} MB after")
    assert SANITIZED or robot.memory() < before + 60


def token(robot):
    robot.until_heard("Open it with the token: ")
    secret = next(found[1] for line in robot.lines if (found := re.search(r"the token: \S+\?token=(\w+)", line)))
    client = Client(robot.port, "?token=" + secret)
    client.subscribe("/rosout")
    client.until(lambda: any("the page is at" in line.msg for line in client.messages.get("/rosout", [])))
    told = [line.msg for line in client.messages["/rosout"] if secret in line.msg]
    assert not told, f"the token is on /rosout: {told}"
    for path, status in (("", 403), ("?token=guess", 403), ("?token=" + secret[:-1], 403), ("?token=" + secret, None)):
        try:
            Client(robot.port, path)
            assert status is None, path
        except InvalidStatus as refused:
            assert refused.response.status_code == status, path


def soak(robot):
    """Five clients that subscribe to everything, one of them driving; TANDEM_SOAK: duration [s]."""
    clients = [Client(robot.port) for _ in range(5)]
    for client in clients:
        client.decodes = False
        client.until(lambda: len(client.channels) > 15)
        for topic in list(client.channels):
            if client.channels[topic]["encoding"] == "cdr":
                client.subscribe(topic)
    clients[0].advertise(1, "/joy", "sensor_msgs/msg/Joy")
    end, rest = time.monotonic() + float(os.environ.get("TANDEM_SOAK", "5" if SANITIZED else "30")), threading.Event()

    def listen(client, beat):
        try:
            client.until(rest.is_set, beat, timeout=1e9)
        except ConnectionClosed:
            rest.set()

    drives = push(clients[0], 0.6, 0.4)
    threads = [threading.Thread(target=listen, args=(c, drives if c is clients[0] else None), daemon=True)
               for c in clients]
    for thread in threads:
        thread.start()
    memory = []
    while time.monotonic() < end:
        assert not rest.wait(1.0), "a client was dropped"
        memory.append(robot.memory())
    rest.set()
    settled = memory[len(memory) // 2:]
    print(f"{len(memory)} s: {memory[0]:.1f} MB at first, {settled[0]:.1f} MB half way, {settled[-1]:.1f} MB")
    assert SANITIZED or settled[-1] < settled[0] + max(0.05 * len(settled), 0.5)  # [MB]: 50 kB a second


def expect_closed(client):
    try:
        while True:
            client.socket.recv(LONG)
    except ConnectionClosed:
        pass


def foreign(robot):
    """Other nodes on the domain: three types under one name, a name with "__", several latched publishers."""
    client = Client(robot.port)
    client.decodes = False
    joys = lambda: [c for c in client.offered if c["topic"] == "/joy"]
    client.until(lambda: len({c["schemaName"] for c in joys()}) == 3)
    for number, channel in enumerate(joys(), 100):
        client.wanted[number] = ("/joy", channel["schemaName"])
        client.say(op="subscribe", subscriptions=[{"id": number, "channelId": channel["id"]}])
    client.until(lambda: any("in use in this process with two other types" in s for s in client.statuses))
    client.say(op="getParameters", parameterNames=[], id="all")
    client.until(lambda: "/my__node.use_sim_time" in client.parameters and "/teleop.max_v" in client.parameters
                 or any(p.startswith("/my__node.") for p in client.parameters))
    frames = {"base_scan", "foreign_0", "foreign_1", "foreign_2"}
    for _ in range(2):  # an early and a late subscriber
        viewer = Client(robot.port)
        viewer.subscribe("/tf_static")
        viewer.until(lambda: frames <= {t.child_frame_id for m in viewer.messages.get("/tf_static", [])
                                        for t in m.transforms})


def slow(robot):
    """A client that reads nothing is disconnected."""
    lazy, other = Client(robot.port), Client(robot.port)
    for topic in ("/odom", "/scan", "/map", "/octomap_binary"):
        lazy.subscribe(topic)  # and never reads it
    other.until(lambda: "/dashboard/seat" in other.channels)
    driver_channel = other.channels["/dashboard/seat"]
    other.say(op="subscribe", subscriptions=[{"id": 7, "channelId": driver_channel["id"]}])
    end, clients = time.monotonic() + LONG, []
    while clients[-1:] != [1]:
        assert time.monotonic() < end, "the slow client is still there"
        frame = other.socket.recv(LONG)
        if frame[0] == 1:
            clients.append(json.loads(frame[13:])["clients"])
    assert 2 in clients


CHECKS = {check.__name__: check for check in (drive, sdk, seat, leave, trial, door, token, hostile, foreign, slow, soak)}
PARAMETERS = {"token": ("address:=0.0.0.0",)}

if __name__ == "__main__":
    program, system_file, wanted = sys.argv[1:]
    the_robot = Robot(program, system_file, *PARAMETERS.get(wanted, ()))
    try:
        CHECKS[wanted](the_robot)
    finally:
        the_robot.stop()

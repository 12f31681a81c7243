# SPDX-License-Identifier: Apache-2.0
"""Our robot in a process, and a third-party WebSocket client of its dashboard."""

import itertools
import json
import re
import signal
import struct
import subprocess
import sys
import threading
import time

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from websockets.sync.client import connect

PROTOCOL = "foxglove.websocket.v1"
LONG = 60.0  # [s] for a slow machine


class Robot:
    """The system in a separate process, and the port of its dashboard."""

    def __init__(self, tandem, system, *parameters):
        options = [option for p in ("port:=0", *parameters) for option in ("-p", "dashboard:" + p)]
        self.process = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", tandem, "run", system, "--ros-args", *options],
                                        stderr=subprocess.PIPE, text=True, errors="replace")
        self.lines, self.news = [], threading.Condition()
        for line in self.hear():
            if found := re.search(r"the page is at http://[^:]+:(\d+)/", line):
                self.port = int(found[1])
                break
        else:
            raise AssertionError("the robot did not start")
        threading.Thread(target=lambda: list(self.hear()), daemon=True).start()

    def hear(self):
        for line in self.process.stderr:
            sys.stderr.write(line)
            with self.news:
                self.lines.append(line)
                self.news.notify_all()
            yield line

    def until_heard(self, text):
        with self.news:
            heard = self.news.wait_for(lambda: any(text in line for line in self.lines), LONG)
        assert heard, f"the terminal does not tell: {text}"

    def memory(self):
        """Resident memory [MB]."""
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as status:
            return int(re.search(r"VmRSS:\s+(\d+)", status.read())[1]) / 1024

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(20) == 0


class Client:
    """Implements the protocol; decodes messages with the schemas that the server sends."""

    def __init__(self, port, query="", **options):
        self.socket = connect(f"ws://127.0.0.1:{port}/{query}", subprotocols=[PROTOCOL], max_size=None, **options)
        self.channels, self.services, self.statuses, self.messages, self.answers = {}, {}, [], {}, {}
        self.offered = []  # channels, including one per type of a topic
        self.parameters, self.decodes = {}, True
        self.types = get_typestore(Stores.EMPTY)
        self.wanted = {}
        self.info = json.loads(self.socket.recv(LONG))

    def take(self, timeout=LONG):
        frame = self.socket.recv(timeout)
        if isinstance(frame, str):
            self.on_text(json.loads(frame))
        elif frame[0] == 1:
            number, = struct.unpack_from("<I", frame, 1)
            topic, name = self.wanted[number]
            if self.decodes:
                self.messages.setdefault(topic, []).append(
                    json.loads(frame[13:]) if name is None else self.types.deserialize_cdr(frame[13:], name))
        elif frame[0] == 3:
            _, call, size = struct.unpack_from("<III", frame, 1)
            self.answers[call] = frame[13 + size:]

    def on_text(self, frame):
        if frame["op"] == "advertise":
            self.channels.update({c["topic"]: c for c in frame["channels"]})
            self.offered += frame["channels"]
        elif frame["op"] == "advertiseServices":
            self.services.update({s["name"]: s for s in frame["services"]})
        elif frame["op"] == "status":
            self.statuses.append(frame["message"])
        elif frame["op"] == "parameterValues":
            self.parameters.update({p["name"]: p["value"] for p in frame["parameters"]})
        elif frame["op"] == "serviceCallFailure":
            self.answers[frame["callId"]] = frame["message"]

    def until(self, done, beat=None, timeout=LONG):
        end, next_beat = time.monotonic() + timeout, 0.0
        while not done():
            assert time.monotonic() < end, "in vain"
            if beat and time.monotonic() > next_beat:
                beat()
                next_beat = time.monotonic() + 0.03
            try:
                self.take(0.01 if beat else LONG)
            except TimeoutError:
                pass

    def say(self, **request):
        self.socket.send(json.dumps(request))

    def subscribe(self, topic):
        self.until(lambda: topic in self.channels)
        channel = self.channels[topic]
        is_json = channel["encoding"] == "json"
        if self.decodes and not is_json:
            self.types.register(get_types_from_msg(channel["schema"], channel["schemaName"]))
        number = len(self.wanted)
        self.wanted[number] = (topic, None if is_json else channel["schemaName"])
        self.say(op="subscribe", subscriptions=[{"id": number, "channelId": channel["id"]}])

    def newest(self, topic):
        return self.messages.get(topic, [None])[-1]

    def advertise(self, number, topic, name, encoding="cdr"):
        self.say(op="advertise",
                 channels=[{"id": number, "topic": topic, "encoding": encoding, "schemaName": name}])

    def publish(self, number, payload):
        self.socket.send(struct.pack("<BI", 1, number) + payload)

    def call(self, name, payload):
        self.until(lambda: name in self.services)
        number = len(self.answers) + 1
        self.socket.send(struct.pack("<BIII", 2, self.services[name]["id"], number, 3) + b"cdr" + payload)
        self.until(lambda: number in self.answers)
        return self.answers[number]


def joy(linear, angular, held):
    """sensor_msgs/msg/Joy without a stamp."""
    return (b"\0\1\0\0" + struct.pack("<iII", 0, 0, 1) + b"\0" + b"\0" * 3 +
            struct.pack("<IffIi", 2, angular, linear, 1, held))


def push(client, linear, angular):
    """A beat that pushes the stick after a rest, as all our devices do. It rests several times, because teleop
    may not be running yet."""
    rest, pushed = joy(0.0, 0.0, 1), joy(linear, angular, 1)
    samples = itertools.chain(([rest] + 30 * [pushed]) * 5, itertools.repeat(pushed))
    return lambda: client.publish(1, next(samples))


def string(text):
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<I", len(data)) + data

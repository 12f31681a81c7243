# SPDX-License-Identifier: Apache-2.0
"""The hostile web clients of attacks.py: what they send, each in a process of the lowest priority."""

import contextlib
import itertools
import json
import multiprocessing
import os
import signal
import socket
import struct
import threading
import time

from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from client import PROTOCOL

HOSTILE = 14
RATE, BYTE_RATE, PARTS = 290.0, 480e3, 2900.0  # [Hz], [B/s], [Hz]: just within the limits
BEAT = 0.5  # [s] for which a client saves, to send all of it at once
BEATS = {"damaged presses of the stop": 0.05}  # more than 16 waiting presses close the connection


def text(**request):
    return json.dumps(request, separators=(",", ":"))


def encoded(frame):
    """The bytes of a frame: text, binary, a list of the parts of one, or None for a ping. A mask of zeros leaves
    the payload as it is, so that sending costs the attacker next to nothing."""
    parts = frame if isinstance(frame, list) else [frame]
    first = 9 if frame is None else 1 if isinstance(frame, str) else 2
    wire = b""
    for i, part in enumerate(parts):
        payload = part.encode() if isinstance(part, str) else part or b""
        size = len(payload)
        length = struct.pack("!B", 0x80 | size) if size < 126 else struct.pack("!BH", 0xfe, size)
        wire += bytes([(0x80 if i + 1 == len(parts) else 0) | (0 if i else first)]) + length + bytes(4) + payload
    return wire


def cost(frame):
    """How long [s] a client must save for it."""
    parts = len(frame) if isinstance(frame, list) else 1
    return max(1.0 / RATE, len(encoded(frame)) / BYTE_RATE, parts / PARTS)


def message(channel, payload):
    return struct.pack("<BI", 1, channel) + payload


def call(service, size=1):
    """With a request of that many zero bytes: an empty one, or lists without elements."""
    return struct.pack("<BIII", 2, service, 10**6, 3) + b"cdr" + b"\0\1\0\0" + bytes(size)


def unknown_names(count):
    return [f"/n{i}.p" for i in range(count)]


def many_values():
    return '{"op":"x","y":[' + ",".join(7000 * ['{"":[]}']) + "]}"


def bad_values(count):
    return text(op="setParameters", parameters=[{"name": "b", "value": i} for i in range(count)])


def unknown_channels(count):
    return text(op="subscribe", subscriptions=[{"id": i, "channelId": 10**6 + i} for i in range(count)])


def toggled(known):
    ids = [channel["id"] for channel in known.channels]
    return [text(op="subscribe", subscriptions=[{"id": i, "channelId": i} for i in ids]),
            text(op="unsubscribe", subscriptionIds=ids)]


def everything(known):
    return [text(op="subscribe", subscriptions=[{"id": c["id"], "channelId": c["id"]} for c in known.channels]),
            *100 * [text(op="getParameters", parameterNames=[])]]


def calls(known):
    wanted = []
    for service in known.services:
        name = service["type"].split("/")[-1]
        if name.startswith(("Get", "List", "Describe")):
            size = 16 if name == "ListParameters" else 4 if "Parameter" in name or "Logger" in name else 1
            wanted.append(call(service["id"], size))
    return wanted


def presses(_):
    return [text(op="advertise", channels=[{"id": 1, "topic": "/e_stop", "encoding": "cdr",
                                            "schemaName": "std_msgs/msg/Bool"}]),
            *200 * [message(1, b"\0"), message(1, b"\1")]]


# What each of them sends repeatedly, built from what the server announced.
KINDS = {
    "getParameters of 5,500 nodes": lambda _: [text(op="getParameters", parameterNames=unknown_names(5500))],
    "getParameters of all": lambda _: [text(op="getParameters", parameterNames=[])],
    "setParameters with 2,300 bad ones": lambda _: [bad_values(2300)],
    "1,700 subscriptions to no channel": lambda _: [unknown_channels(1700)],
    "all channels on and off": toggled,
    "JSON of 14,000 values": lambda _: [many_values()],
    "service calls": calls,
    "taking the wheel": lambda _: [call(1)],
    "damaged presses of the stop": presses,
    "asks for all and reads nothing": everything,
    "pings": lambda _: [None],
    "frames in 100 parts": lambda _: [100 * [b"\1"]],
    "getParameters of 1,000 nodes": lambda _: [text(op="getParameters", parameterNames=unknown_names(1000))],
    "setParameters with 1,000 bad ones": lambda _: [bad_values(1000)],
    "500 subscriptions to no channel": lambda _: [unknown_channels(500)],
}
RECONNECTS = "comes, asks and goes"
STRANGER = "files, and half a request"


class Hostile:
    """One connection that sends the given frames as fast as its limits allow, and reconnects when closed. It sends
    what it may in a beat at once, and at the same moments as all the others."""

    def __init__(self, kind, url, over):
        self.kind, self.url, self.over = kind, url, over
        self.frames = self.closed = 0
        self.channels, self.services = [], []

    def run(self):
        attack = self.ask_and_go if self.kind == RECONNECTS else self.flood
        while not self.over():
            try:
                with connect(self.url, subprotocols=[PROTOCOL], max_size=None, close_timeout=0.1,
                             ping_interval=None) as web:
                    attack(web)
            except (WebSocketException, OSError, TimeoutError, EOFError):
                self.closed += 1
                time.sleep(0.02)

    def ask_and_go(self, web):
        for _ in range(3):
            web.send(text(op="getParameters", parameterNames=unknown_names(900)))
            self.frames += 1
        web.socket.shutdown(socket.SHUT_RDWR)

    def learn(self, web):
        """What the server announces."""
        self.channels, self.services = [], []
        while not (self.channels and self.services):
            frame = web.recv(5.0)
            told = json.loads(frame) if isinstance(frame, str) else {}
            self.channels += told.get("channels", []) if told.get("op") == "advertise" else []
            self.services += told.get("services", [])

    def flood(self, web):
        self.learn(web)
        if self.kind != "asks for all and reads nothing":
            threading.Thread(target=self.drain, args=(web,), daemon=True).start()
        frames = itertools.cycle([(encoded(frame), cost(frame)) for frame in KINDS[self.kind](self)])
        beat, saved = BEATS.get(self.kind, BEAT), 0.0
        wire, needed = next(frames)
        while not self.over():
            time.sleep(beat - time.monotonic() % beat)  # the clock is the same in all processes
            saved, burst = saved + beat, b""
            while needed <= saved:
                saved, burst = saved - needed, burst + wire
                self.frames += 1
                wire, needed = next(frames)
            web.socket.sendall(burst)

    @staticmethod
    def drain(web):
        with contextlib.suppress(WebSocketException, OSError, EOFError):
            while True:
                web.recv()


def stranger(port, over):
    """Without a token: fetches the page repeatedly and holds half a request on other connections."""
    count, half = 0, []
    while not over():
        with contextlib.suppress(OSError):
            half.append(socket.create_connection(("127.0.0.1", port), 1.0))
            half[-1].sendall(b"GET / HT")
            half = half[-20:]
            with socket.create_connection(("127.0.0.1", port), 1.0) as web:
                web.sendall(b"GET /app.js HTTP/1.1\r\nHost: localhost\r\n\r\n")
                while web.recv(65536):
                    pass
            count += 1
    return count, 0


def work(pipe):
    """A separate process for each hostile client, which repeats its order until it gets another."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(19)
    with contextlib.suppress(EOFError, OSError):
        while True:
            kind, url, port = pipe.recv()
            if kind == STRANGER:
                pipe.send(stranger(port, pipe.poll))
            else:
                hostile = Hostile(kind, url, pipe.poll)
                hostile.run()
                pipe.send((hostile.frames, hostile.closed))
            pipe.recv()


def stand(pipe):
    """The longest time [s] since the last query that this process was runnable but not running: how much other
    programs delay a process of the robot's priority."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(EOFError, OSError):
        most = 0.0
        while True:
            begin = time.monotonic()
            time.sleep(0.001)
            most = max(most, time.monotonic() - begin - 0.001)
            if pipe.poll():
                pipe.recv()
                pipe.send(most)
                most = 0.0


class Crowd:
    """The hostile clients, and one process that measures how busy the machine is. Created before the robot, so
    that the forks copy no threads."""

    def __init__(self):
        fork = multiprocessing.get_context("fork")
        self.pipes = []
        for _ in range(HOSTILE):
            mine, its = fork.Pipe()
            fork.Process(target=work, args=(its,), daemon=True).start()
            self.pipes.append(mine)
        self.machine, its = fork.Pipe()
        fork.Process(target=stand, args=(its,), daemon=True).start()

    def stood(self):
        """Maximum [s] since the last query."""
        self.machine.send(None)
        return self.machine.recv()

    @contextlib.contextmanager
    def attacking(self, kinds, url, port, seconds=1.5):
        """The totals at the end: frames sent, connections that were closed."""
        outcome = []
        for pipe, kind in zip(self.pipes, kinds):
            pipe.send((kind, url, port))
        time.sleep(seconds)
        try:
            yield outcome
        finally:
            for pipe in self.pipes:
                pipe.send("stop")
            results = [pipe.recv() for pipe in self.pipes]
            outcome += [sum(r[0] for r in results), sum(r[1] for r in results)]

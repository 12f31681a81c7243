# SPDX-License-Identifier: Apache-2.0
"""Times a client that presses the emergency stop and takes the wheel beside fourteen hostile ones:
attacks.py TANDEM SYSTEM [PRESSES]. Prints the table of dashboard/README.md; a run of few presses is compared
with the same machine without an attack, one of 200 with the limits themselves. The longest stall of another process
of the robot's priority is printed too, and added to the limit of the worst."""

import contextlib
import logging
import multiprocessing
import os
import random
import resource
import select
import signal
import socket
import statistics
import sys
import tempfile
import threading
import time

from websockets.exceptions import WebSocketException

from client import LONG, PROTOCOL, Client, Robot, string
from hostile import HOSTILE, KINDS, RECONNECTS, STRANGER, Crowd, call

MEDIAN, WORST, GROWTH, END = 0.020, 0.050, 100.0, 2.0  # [s], [s], [MB], [s]
FULL = 200  # from this many presses on, the limits are checked strictly
TOKEN = "a-token-for-the-attacks"
APART = (0.01, 0.05)  # [s] between two presses


# --- the one that is not hostile ---------------------------------------------------------------------------

class Person(Client):
    """Presses the emergency stop until the robot's topic reports it; takes the wheel until it drives."""

    def __init__(self, port, presses=True, **options):
        super().__init__(port, "?token=" + TOKEN, **options)
        self.port = port
        if not presses:
            return
        self.advertise(1, "/e_stop", "std_msgs/msg/Bool")
        self.pressed = False
        self.press()
        self.subscribe("/e_stop")
        self.subscribe("/arbitration/status")
        self.until(lambda: self.messages.get("/e_stop") and self.messages.get("/arbitration/status"))

    def press(self):
        self.pressed = not self.pressed
        self.publish(1, b"\0\1\0\0" + bytes([self.pressed]))

    def time_stop(self):
        before, begin = len(self.messages["/e_stop"]), time.monotonic()
        self.press()
        self.until(lambda: len(self.messages["/e_stop"]) > before)
        return time.monotonic() - begin

    def time_wheel(self):
        begin = time.monotonic()
        assert b"you are driving" in self.call("/dashboard/take_wheel", b"\0\1\0\0\0")
        return time.monotonic() - begin

    def as_driver(self, service, payload, wanted):
        """Calls a service that only the driver may call until it succeeds; others take the wheel meanwhile."""
        self.until(lambda: {"/dashboard/take_wheel", service} <= self.services.keys())
        answer, end = b"", time.monotonic() + LONG
        while wanted not in answer:
            assert time.monotonic() < end, f"in vain: {service}: {answer}"
            self.socket.send(call(self.services["/dashboard/take_wheel"]["id"]))
            answer = self.call(service, payload)
            answer = answer if isinstance(answer, bytes) else answer.encode()

    def time_leaving(self):
        """Another client starts autonomous driving and loses its connection: the time until the policy is shared."""
        policy = lambda: self.newest("/arbitration/status").policy
        if self.pressed:
            self.time_stop()
        leaver = Person(self.port, presses=False, close_timeout=0.1)
        leaver.as_driver("/arbitration/release_emergency_stop", b"\0\1\0\0\0", b"released")
        leaver.as_driver("/arbitration/set_policy", string("autonomous"), b"policy is now autonomous")
        self.until(lambda: policy() == "autonomous")
        begin = time.monotonic()
        leaver.socket.socket.shutdown(socket.SHUT_RDWR)
        self.until(lambda: policy() == "shared")
        return time.monotonic() - begin

    def times(self, count):
        """Times [s] of that many presses and take-overs at random moments."""
        chance, stops, wheels = random.Random(7), [], []
        for _ in range(count):
            for what, times in ((self.time_stop, stops), (self.time_wheel, wheels)):
                time.sleep(chance.uniform(*APART))
                times.append(what())
        return stops, wheels


class Memory(threading.Thread):
    """Peak memory [MB] of the robot's process since the last query."""

    def __init__(self, robot):
        super().__init__(daemon=True)
        self.robot, self.most = robot, robot.memory()
        self.start()

    def run(self):
        with contextlib.suppress(OSError, TypeError):
            while True:
                self.most = max(self.most, self.robot.memory())
                time.sleep(0.05)


# --- a reverse proxy -------------------------------------------------------------------------------------------

class Proxy(threading.Thread):
    """Forwards TCP, and adds X-Forwarded-For with the peer's address to the first request."""

    def __init__(self, port, apart=False):
        """`apart`: in a separate process with the low priority of the hostile clients."""
        super().__init__(daemon=True)
        self.to, self.apart = port, apart
        self.listener = socket.create_server(("127.0.0.1", 0), backlog=1000)
        self.port = self.listener.getsockname()[1]
        if apart:
            multiprocessing.get_context("fork").Process(target=self.run, daemon=True).start()
        else:
            self.start()

    def run(self):
        if self.apart:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            os.nice(19)
        while True:
            near, (address, _) = self.listener.accept()
            threading.Thread(target=self.forward, args=(near, address), daemon=True).start()

    def forward(self, near, address):
        with contextlib.suppress(OSError), near, socket.create_connection(("127.0.0.1", self.to)) as far:
            for one in (near, far):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            head = near.recv(65536)
            line, _, rest = head.partition(b"\r\n")
            far.sendall(line + b"\r\nX-Forwarded-For: " + address.encode() + b"\r\n" + rest if rest else head)
            while True:
                ready, _, _ = select.select([near, far], [], [])
                for one, other in ((near, far), (far, near)):
                    if one in ready:
                        data = one.recv(65536)
                        if not data:
                            return
                        other.sendall(data)


# --- the attacks -----------------------------------------------------------------------------------------------

def ms(times):
    return f"median {1e3 * statistics.median(times):.0f} ms, worst {1e3 * max(times):.0f} ms"


def row(kind, tries, outcome):
    print(f"| {kind} | {tries} | {outcome} |", flush=True)


class Limits:
    """Prints what must hold and whether it does."""

    def __init__(self, presses, idle):
        self.failed = []
        stops, wheels = idle
        reading = max(statistics.median(stops), statistics.median(wheels)), max(*stops, *wheels)
        self.median, self.worst = MEDIAN, WORST
        if presses < FULL:  # a busy machine is slow without an attack, too
            self.median = max(MEDIAN, 3.0 * reading[0])
            self.worst = max(10.0 * WORST, 5.0 * reading[1])

    def check(self, holds, what):
        if not holds:
            self.failed.append(what)

    def judge(self, kind, stops, wheels, stood):
        for name, times in (("emergency stop", stops), ("take-over", wheels)):
            self.check(statistics.median(times) <= self.median and max(times) <= self.worst + stood,
                       f"{kind}: {name}: {ms(times)}")


def leave(crowd, kinds, robot, person, limits, tries):
    idle = [person.time_leaving() for _ in range(tries)]
    with crowd.attacking(kinds, f"ws://127.0.0.1:{robot.port}/?token={TOKEN}", robot.port):
        times = [person.time_leaving() for _ in range(tries)]
    row("the client that lets the robot drive by itself is lost during all of them", tries,
        f"policy shared again: {ms(times)} (nobody attacks: {ms(idle)})")
    limits.check(max(times) <= 3.0 * max(idle) + WORST, f"a departure acts after {ms(times)}")


def measure(kind, kinds, crowd, robot, person, limits, count, port=None):
    port = port or robot.port
    before, memory = robot.memory(), Memory(robot)
    with crowd.attacking(kinds, f"ws://127.0.0.1:{port}/?token={TOKEN}", port) as outcome:
        crowd.stood()
        stops, wheels = person.times(count)
        stood = crowd.stood()
    growth = memory.most - before
    row(kind, f"{outcome[0]} frames, {outcome[1]} connections closed; {count} presses",
        f"stop: {ms(stops)}; take-over: {ms(wheels)}; {growth:+.0f} MB; another process stood {1e3 * stood:.0f} ms")
    limits.judge(kind, stops, wheels, stood)
    limits.check(growth <= GROWTH, f"{kind}: {growth:.0f} MB")


def connected(port, end):
    """A client that, like the page, tries again when its request is displaced before it is read."""
    while True:
        try:
            return Client(port, "?token=" + TOKEN, close_timeout=0.1)
        except (OSError, WebSocketException):
            if time.monotonic() > end:
                raise


def half_open(port, limits, source=None):
    """Half a request on 60 connections, reopened when closed; then a client with a token connects."""
    over, opened = threading.Event(), [0]

    def hold():
        while not over.is_set():
            with contextlib.suppress(OSError):
                with socket.create_connection(("127.0.0.1", port), 1.0, source_address=source) as one:
                    one.sendall(b"GET / HT")
                    opened[0] += 1
                    one.settimeout(5.0)
                    one.recv(1)

    threads = [threading.Thread(target=hold, daemon=True) for _ in range(60)]
    for thread in threads:
        thread.start()
    time.sleep(0.5)
    took = []
    for _ in range(5):
        begin = time.monotonic()
        client = connected(port, begin + LONG)
        took.append(time.monotonic() - begin)
        client.socket.close()
    over.set()
    limits.check(max(took) < 2.0, f"half-open connections: a newcomer waits {max(took):.1f} s")
    return opened[0], took


def status(port, token, source=None):
    with socket.create_connection(("127.0.0.1", port), LONG, source_address=source) as raw:
        raw.sendall((f"GET /?token={token} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                     f"Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                     f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n").encode())
        return int(raw.makefile("rb").readline().split()[1])


def guess(port, limits, count, source=None, other=None):
    """Wrong tokens in sequence, and a valid one from the same address in between."""
    answers, valid = {}, []
    for i in range(count):
        answer = status(port, f"guess-number-{i:06}", source)
        answers[answer] = answers.get(answer, 0) + 1
        if i % (count // 10) == 0:
            begin = time.monotonic()
            limits.check(status(port, TOKEN, source) == 101, "a valid token is refused beside wrong ones")
            valid.append(time.monotonic() - begin)
    limits.check(answers.get(429, 0) > 0.9 * count and 101 not in answers, f"wrong tokens: {answers}")
    if other:
        limits.check(status(port, "wrong-from-elsewhere", other) == 403, "an address waits for another")
    return answers, valid


def at_the_door(robot, limits, tries):
    opened, took = half_open(robot.port, limits)
    row("60 half-open connections of one address, renewed at once", f"{opened} opened",
        f"5 newcomers with a token came in, each within {1e3 * max(took):.0f} ms")
    answers, valid = guess(robot.port, limits, tries)
    row("wrong tokens", tries, f"answers by status: {answers}; 10 valid ones between them from the same address: "
        f"at once, within {1e3 * max(valid):.0f} ms")


def behind_a_proxy(tandem, system, token_file, crowd, mix, limits, presses):
    robot, tries = Robot(tandem, system, "token_file:=" + token_file, "trusted_proxies:=127.0.0.1"), 5 * presses
    try:
        proxy, other = Proxy(robot.port), Proxy(robot.port, apart=True)
        person = Person(proxy.port)
        idle = person.times(presses)
        row("none, through a reverse proxy", f"{presses} presses", f"stop: {ms(idle[0])}; take-over: {ms(idle[1])}")
        measure("14 different ones at once through another one", mix, crowd, robot, person, limits, presses, other.port)
        opened, took = half_open(proxy.port, limits, source=("127.0.0.2", 0))
        row("60 half-open connections of one address through a reverse proxy", f"{opened} opened",
            f"5 newcomers of another address came in, each within {1e3 * max(took):.0f} ms")
        answers, valid = guess(proxy.port, limits, tries, ("127.0.0.2", 0), ("127.0.0.3", 0))
        row("wrong tokens through it", tries, f"answers by status: {answers}; valid ones of that address within "
            f"{1e3 * max(valid):.0f} ms; a wrong one of another address does not wait")
    finally:
        robot.stop()


def end(crowd, kinds, robot, limits):
    """SIGINT during the attack."""
    with crowd.attacking(kinds, f"ws://127.0.0.1:{robot.port}/?token={TOKEN}", robot.port):
        begin = time.monotonic()
        robot.process.send_signal(signal.SIGINT)
        code = robot.process.wait(LONG)
        took = time.monotonic() - begin
    row("SIGINT during all of them", 1, f"the process ended with {code} after {took:.2f} s")
    limits.check(code == 0 and took <= END, f"SIGINT: status {code} after {took:.2f} s")


def main(tandem, system, presses):
    resource.setrlimit(resource.RLIMIT_NOFILE, (4096, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    logging.disable(logging.CRITICAL)  # messages of websockets about lost connections
    crowd = Crowd()
    with tempfile.NamedTemporaryFile("w", suffix=".token") as file:
        file.write(TOKEN + "\n")
        file.flush()
        robot = Robot(tandem, system, "token_file:=" + file.name)
        mix = [*KINDS][:HOSTILE - 2] + [RECONNECTS, STRANGER]  # the twelve most expensive
        try:
            person = Person(robot.port)
            crowd.stood()
            idle = person.times(presses)
            stood = crowd.stood()
            limits = Limits(presses, idle)
            print("| kind | tries | outcome |\n|---|---|---|")
            row("none: nobody attacks", f"{presses} presses", f"stop: {ms(idle[0])}; take-over: {ms(idle[1])}; "
                f"another process stood {1e3 * stood:.0f} ms")
            if presses >= FULL:
                for kind in [*KINDS, RECONNECTS, STRANGER]:
                    measure(f"14 × {kind}", HOSTILE * [kind], crowd, robot, person, limits, presses // 10)
            measure("14 different ones at once", mix, crowd, robot, person, limits, presses)
            leave(crowd, mix, robot, person, limits, max(5, presses // 10))
            at_the_door(robot, limits, 5 * presses)
            end(crowd, mix, robot, limits)
        finally:
            if robot.process.poll() is None:
                robot.stop()
        behind_a_proxy(tandem, system, file.name, crowd, mix, limits, presses)
    for failure in limits.failed:
        print("FAILED:", failure)
    return 1 if limits.failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else FULL))

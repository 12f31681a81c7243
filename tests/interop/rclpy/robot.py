# SPDX-License-Identifier: Apache-2.0
"""Our programs and the ros2 commands in a DDS domain that no other test uses meanwhile."""
import fcntl
import os
import re
import subprocess
import time

SOURCE = os.environ['TANDEM_SOURCE_DIR']
BINARY = os.environ['TANDEM_BINARY_DIR']
PATIENCE = 60.0  # [s]; even a busy machine usually needs only 1 s


def take_domain():
    """As tests/support/private_domain.hpp; held until the process ends."""
    for tried in range(100):
        domain = 1 + (os.getpid() + tried) % 100
        file = open(f'/tmp/tandem_test_domain_{domain}', 'w')
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            continue
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
        os.environ.pop('ROS_LOCALHOST_ONLY', None)
        return file
    raise RuntimeError('every test domain is in use')


def start(program, *arguments):
    return subprocess.Popen([f'{BINARY}/{program}', *arguments])


def stop(process):
    process.terminate()
    return process.wait(20)


def until(condition, what, turn=0.05):
    """The first true value of condition(); fails after PATIENCE."""
    end = time.monotonic() + PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError(f'{what}: not within {PATIENCE} s')
        time.sleep(turn)


def ros2(*arguments):
    """What a ros2 command prints, whatever it returns."""
    done = subprocess.run(['ros2', *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=PATIENCE)
    return done.stdout


def asked(*arguments):
    """The same without a daemon, which would keep another test's domain."""
    return ros2(*arguments, '--no-daemon', '--spin-time', '2')


def says(expected, *arguments, ask=asked):
    """Asks until the answer matches; discovery takes its time on a busy machine."""
    seen = ''

    def matches():
        nonlocal seen
        seen = ask(*arguments)
        return re.search(expected, seen, re.MULTILINE | re.DOTALL)

    try:
        until(matches, ' '.join(arguments))
    except AssertionError as late:
        raise AssertionError(f'{late}\nno {expected!r} in:\n{seen}') from None
    return seen

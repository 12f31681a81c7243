# SPDX-License-Identifier: Apache-2.0
"""Compares the drives in the folders of studies, without what a clock measured, and where they ran."""
import pathlib
import sqlite3
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OF_THE_COMPUTER = {'cpu_s', 'wall_s', 'cost_s', 'plan_overruns', 'missed_deadlines', 'build', 'machine'}


def drives(folder):
    """The measures and the track of each drive, by scenario, method, driver and seed."""
    database = sqlite3.connect(pathlib.Path(folder) / 'drives.sqlite')
    database.row_factory = sqlite3.Row
    found = {}
    for row in database.execute('SELECT * FROM drives JOIN tracks USING (scenario, method, driver, seed)'):
        drive = {key: row[key] for key in row.keys()
                 if key not in OF_THE_COMPUTER and not key.startswith(('part_s.', 'plan_ms.'))}
        drive['map'] = pathlib.Path(drive['map']).name  # checkouts are in different folders
        found[row['scenario'], row['method'], row['driver'], row['seed']] = drive
    return found


def origins(folder):
    """What drove the drives: (build, machine)."""
    database = sqlite3.connect(pathlib.Path(folder) / 'drives.sqlite')
    return set(database.execute('SELECT DISTINCT build, machine FROM drives'))


def differences(folder, other):
    """A line for each drive that is not the same, to the last bit, in both folders."""
    ours, theirs = drives(folder), drives(other)
    for name in sorted(ours.keys() | theirs.keys()):
        if name not in ours or name not in theirs:
            yield f'{name} is only in {folder if name in ours else other}'
        elif ours[name] != theirs[name]:
            keys = [key for key in ours[name] if ours[name][key] != theirs[name][key]]
            yield f'{name}: {", ".join(keys)} differ'


def must_be_equal(folder, other):
    """Exits with status 1 and the differences if there are any."""
    found = list(differences(folder, other))
    if found:
        sys.exit('\n'.join(found[:40]))
    print(f'{len(drives(folder))} drives, the same in {folder} and {other}')


def install(*packages):
    """Installs Debian packages, unless they are installed."""
    state = subprocess.run(['dpkg-query', '-W', '-f', '${db:Status-Status}\n', *packages], text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False).stdout.split()
    if state.count('installed') < len(packages):
        subprocess.run(['apt-get', 'update', '-qq'], check=True)
        subprocess.run(['env', 'DEBIAN_FRONTEND=noninteractive', 'apt-get', 'install', '-y', '-qq',
                        '--no-install-recommends', *packages], stdout=subprocess.DEVNULL, check=True)

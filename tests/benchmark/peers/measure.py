# SPDX-License-Identifier: Apache-2.0
"""Times and instructions of one solve, of the peers and of our own solvers."""
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile

import peers

CYCLE = "solve_checked"  # what each row of our benchmark calls once per cycle: the solves and the check


def percentile(values, p):
    return sorted(values)[int(p * (len(values) - 1))]


def closed_loop(build, peer, steps=120):
    """One closed loop of a peer's: times of a solve in milliseconds, the first of all left out."""
    output = subprocess.check_output(peers.command(build, peer, steps), env=peers.environment(build, peer),
                                     stderr=subprocess.DEVNULL, text=True)
    row = json.loads(output.splitlines()[-1])
    times, cpu = row["ms"][1:], row["cpu_ms"][1:]
    return {**row, "ms": statistics.median(times), "p99": percentile(times, 0.99),
            "cpu_ms": statistics.median(cpu), "cpu_p99": percentile(cpu, 0.99)}


def ours(build, rows, seconds=0.3):
    """The same of each row of our benchmark that the expression names."""
    output = subprocess.check_output(
        [build / "tests" / "planner_benchmark", f"--benchmark_filter={rows}",
         "--benchmark_format=json", f"--benchmark_min_time={seconds}"],
        stderr=subprocess.DEVNULL,
    )
    return {
        row["name"]: {"ms": row["p50_us"] / 1e3, "p99": row["p99_us"] / 1e3,
                      "cpu_ms": row["cpu_p50_us"] / 1e3, "cpu_p99": row["cpu_p99_us"] / 1e3,
                      "cost": row.get("closed_loop_cost"), "violations": row["violations"],
                      "converged": 1.0 - row["not_converged"] / row["iterations"],
                      "iterations": row["iterations_p50"]}
        for row in json.loads(output)["benchmarks"]
    }


def callgrind(command, entry, environment=None):
    """Lines of callgrind's file: what was executed in `entry` and below, or in all of the process."""
    only = [f"--toggle-collect={entry}"] if entry else []
    with tempfile.NamedTemporaryFile() as file:
        subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={file.name}", *only, *command],
                       env=environment, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return pathlib.Path(file.name).read_text().splitlines()


def total(lines):
    return next(int(line.split()[1]) for line in lines if line.startswith("totals:"))


def peer_instructions(build, peer):
    """Million instructions per solve, without the first ones; None without valgrind, or if it fails."""
    few, many, march = 10, 40, "x86-64-v3"  # newer instructions are beyond valgrind 3.19
    if shutil.which("valgrind") is None:
        return None
    environment = peers.environment(build, peer, march)

    def count(steps, *options):
        return total(callgrind([*peers.command(build, peer, steps, march), *options], "", environment))

    try:
        # Once without valgrind, which compiles.
        subprocess.run(peers.command(build, peer, 1, march), env=environment, check=True,
                       capture_output=True)
        around = count(many, "--idle") - count(few, "--idle")
        return (count(many) - count(few) - around) / (many - few) / 1e6
    except subprocess.CalledProcessError:
        return None


def instructions(build, row):
    """Million instructions per cycle of one of our rows; None without valgrind."""
    if shutil.which("valgrind") is None:
        return None
    lines = callgrind([build / "tests" / "planner_benchmark", f"--benchmark_filter=^{row}$",
                       "--benchmark_min_time=0.05"], f"*{CYCLE}*")
    names, called, calls = {}, "", 0
    for line in lines:
        if match := re.match(r"(c?)fn=\((\d+)\)(?: (.*))?", line):
            names.setdefault(match[2], match[3])
            called = names[match[2]] if match[1] else called
        elif line.startswith("calls=") and CYCLE in called:
            calls += int(line[6:].split()[0])
    return total(lines) / calls / 1e6

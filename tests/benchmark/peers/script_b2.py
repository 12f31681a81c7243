# SPDX-License-Identifier: Apache-2.0
"""Script B.2 of Devalla 2020 and the closed loop in which each peer is measured.

A peer is an object with three methods: `prepare(x, X, U)` takes the pose and the guess, `solve()` is
the only one that is timed, and `plan()` returns poses X (N + 1 x 3), controls U (N x 2) and whether
the solver reports that it has reached its tolerance.
"""
import argparse
import json
import os
import pathlib
import time

import casadi as ca
import numpy as np

# Of generated code. PEERS_MARCH: valgrind does not know all instructions of this processor.
FLAGS = ["-O3", f"-march={os.environ.get('PEERS_MARCH', 'native')}"]

N, DT = 15, 0.25
V, W, CHANGE, WORKSPACE = (-0.4, 0.8), (-1.0, 1.0), 0.1, 4.2
Q, R = np.diag([6.0, 6.0, 4.0]), np.diag([0.3, 0.15])
START, GOAL = np.array([-4.0, -4.0, 0.0]), np.array([4.0, 4.0, 0.0])
POLES_X = [-4, -2, 0.5, 3, -2.5, 0, 2, -4, -1, 3, -2, 1, 4, -1, 1, 3]
POLES_Y = [3.5, 3, 3.5, 4, 1.5, 1.5, 2, 0, 0, 0.5, -2, -1, -1, -4, -3, -3]
GAP = 0.45 + 0.225
MISSED = 1e-4  # [m] of a distance, as in planner_benchmark.cpp
FEASIBLE = 1e-3  # of every constraint: the plan of a solve that counts as converged


def euler(x, u):
    """One symbolic step."""
    return x + DT * ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])


def driven(X, U):
    """One step from each of the poses."""
    v, w, theta = U[:, 0], U[:, 1], X[:, 2]
    return X + DT * np.column_stack([v * np.cos(theta), v * np.sin(theta), w])


def stage_cost(x, u, goal=GOAL):
    error = x - goal
    return error.T @ Q @ error + u.T @ R @ u


def distances(x):
    """Of a symbolic pose from each pole's centre, as far as it must be."""
    return ca.vertcat(*[ca.sqrt((x[0] - a) ** 2 + (x[1] - b) ** 2) for a, b in zip(POLES_X, POLES_Y)])


def nearest(X):
    """Distance of numeric poses from the nearest pole's centre."""
    return np.hypot(X[:, :1] - POLES_X, X[:, 1:2] - POLES_Y).min()


def residual(x, X, U):
    """The most by which a plan from pose x breaks a constraint."""
    return max(
        np.abs(X[0] - x).max(),
        np.abs(X[1:] - driven(X[:-1], U)).max(),
        (np.array([V[0], W[0]]) - U).max(),
        (U - np.array([V[1], W[1]])).max(),
        np.abs(np.diff(U, axis=0)).max() - CHANGE,
        np.abs(X[1:, :2]).max() - WORKSPACE,
        GAP - nearest(X[1:]),
    )


def drive(peer, steps, is_idle=False):
    """The closed loop: each solve starts from the last plan, shifted by one step.

    `is_idle`: only the first step solves, which leaves what the loop around the solves costs.
    """
    x, X, U = START.copy(), np.tile(START, (N + 1, 1)), np.zeros((N, 2))
    out = {"ms": [], "cpu_ms": [], "violations": 0, "cost": 0.0, "path": [x.tolist()]}
    converged, worst = 0, 0.0
    for step in range(steps):
        peer.prepare(x, X, U)
        start, cpu_start = time.perf_counter(), time.thread_time()
        if step == 0 or not is_idle:
            peer.solve()
        cpu_end, end = time.thread_time(), time.perf_counter()
        out["ms"].append(1e3 * (end - start))
        out["cpu_ms"].append(1e3 * (cpu_end - cpu_start))
        X, U, reached = peer.plan()
        missed = float(residual(x, X, U))
        worst = max(worst, missed)
        converged += bool(reached) and missed <= FEASIBLE
        out["violations"] += int(nearest(X[1:]) < GAP - MISSED)
        out["cost"] += float(stage_cost(x, U[0]))
        x = driven(x[None], U[:1])[0]
        X, U = np.vstack([X[1:], X[-1:]]), np.vstack([U[1:], U[-1:]])
        out["path"].append(x.tolist())
    out["converged"] = converged / steps
    out["residual"] = worst
    out["error"] = float(np.hypot(*(x - GOAL)[:2]))
    return out


def main(description, options, make):
    """A peer's command line; `make` takes the name of its options and the folder for compiled code."""
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("options", choices=options)
    parser.add_argument("--steps", type=int, default=120)
    parser.add_argument("--idle", action="store_true", help="only the first step solves")
    parser.add_argument("--cache", default="cache", help="folder for compiled code")
    arguments = parser.parse_args()
    peer = make(arguments.options, pathlib.Path(arguments.cache).resolve())
    print(json.dumps(drive(peer, arguments.steps, arguments.idle)))

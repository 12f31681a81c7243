#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Closed loop of Devalla 2020, script B.2, with CasADi and the Ipopt in its wheel.

One JSON object on standard output: `ms`, the time of each solve; `cpu_ms`, its thread's share;
`violations`, how many solutions come nearer to a pole than allowed; `cost`, the sum of the stage costs
along the driven path; `error`, the last ‖x − x_g‖ in the plane; `path`, the poses.

    casadi_script_b2.py script|best [--steps N]
"""
import argparse
import json
import time

import casadi as ca
import numpy as np

N, DT = 15, 0.25
V, W, CHANGE, WORKSPACE = (-0.4, 0.8), (-1.0, 1.0), 0.1, 4.2
Q, R = np.diag([6.0, 6.0, 4.0]), np.diag([0.3, 0.15])
START, GOAL = np.array([-4.0, -4.0, 0.0]), np.array([4.0, 4.0, 0.0])
POLES_X = [-4, -2, 0.5, 3, -2.5, 0, 2, -4, -1, 3, -2, 1, 4, -1, 1, 3]
POLES_Y = [3.5, 3, 3.5, 4, 1.5, 1.5, 2, 0, 0, 0.5, -2, -1, -1, -4, -3, -3]
GAP = 0.45 + 0.225

# The script's options, and the best that were found for the same problem: primal and dual warm
# start, a fixed barrier, a tolerance that fits it.
OPTIONS = {
    "script": {"max_iter": 2000, "acceptable_tol": 1e-8, "acceptable_obj_change_tol": 1e-6},
    "best": {
        "max_iter": 2000,
        "tol": 1e-4,
        "mu_strategy": "monotone",
        "mu_init": 1e-4,
        "mu_target": 1e-4,
        "warm_start_init_point": "yes",
        "warm_start_bound_push": 1e-6,
        "warm_start_slack_bound_push": 1e-6,
        "warm_start_mult_bound_push": 1e-6,
    },
}


def euler(x, u):
    return x + DT * ca.vertcat(u[0] * ca.cos(x[2]), u[0] * ca.sin(x[2]), u[1])


def problem():
    """Multiple shooting; rows: dynamics, then distances, then changes between controls."""
    X, U, P = ca.SX.sym("X", 3, N + 1), ca.SX.sym("U", 2, N), ca.SX.sym("P", 6)
    cost, dynamics = 0, [X[:, 0] - P[:3]]
    for k in range(N):
        error = X[:, k] - P[3:]
        cost += error.T @ Q @ error + U[:, k].T @ R @ U[:, k]
        dynamics.append(X[:, k + 1] - euler(X[:, k], U[:, k]))
    distance = [
        -ca.sqrt((X[0, k] - x) ** 2 + (X[1, k] - y) ** 2) + GAP
        for k in range(N + 1)
        for x, y in zip(POLES_X, POLES_Y)
    ]
    change = [U[:, k + 1] - U[:, k] for k in range(N - 1)]
    rows = ca.vertcat(*dynamics, *distance, *change)
    variables = ca.vertcat(ca.vec(X), ca.vec(U))
    equal, far = 3 * (N + 1), len(distance)
    limits = {
        "lbg": np.r_[np.zeros(equal), np.full(far, -np.inf), np.full(2 * (N - 1), -CHANGE)],
        "ubg": np.r_[np.zeros(equal + far), np.full(2 * (N - 1), CHANGE)],
        "lbx": np.r_[np.tile([-WORKSPACE, -WORKSPACE, -np.inf], N + 1), np.tile([V[0], W[0]], N)],
        "ubx": np.r_[np.tile([WORKSPACE, WORKSPACE, np.inf], N + 1), np.tile([V[1], W[1]], N)],
    }
    return {"f": cost, "x": variables, "g": rows, "p": P}, limits


def shifted(x):
    """The solution one step later, its last control held."""
    X, U = x[: 3 * (N + 1)].reshape(N + 1, 3), x[3 * (N + 1) :].reshape(N, 2)
    return np.r_[X[1:].ravel(), X[-1], U[1:].ravel(), U[-1]]


def drive(options, steps):
    nlp, limits = problem()
    solver = ca.nlpsol(
        "solver", "ipopt", nlp, {"ipopt": {"print_level": 0, "sb": "yes", **options}, "print_time": 0}
    )
    x, guess = START.copy(), np.r_[np.tile(START, N + 1), np.zeros(2 * N)]
    multipliers, times, cpu_times, path, cost, violations = {}, [], [], [x.tolist()], 0.0, 0
    for _ in range(steps):
        start, cpu_start = time.perf_counter(), time.thread_time()
        solution = solver(x0=guess, p=np.r_[x, GOAL], **limits, **multipliers)
        times.append(1e3 * (time.perf_counter() - start))
        cpu_times.append(1e3 * (time.thread_time() - cpu_start))
        z = np.array(solution["x"]).ravel()
        u = z[3 * (N + 1) :][:2]
        X = z[: 3 * (N + 1)].reshape(N + 1, 3)
        distances = np.hypot(X[1:, :1] - POLES_X, X[1:, 1:2] - POLES_Y)
        violations += int(distances.min() < GAP - 1e-4)
        if options.get("warm_start_init_point") == "yes":
            multipliers = {"lam_x0": solution["lam_x"], "lam_g0": solution["lam_g"]}
        cost += float((x - GOAL) @ Q @ (x - GOAL) + u @ R @ u)
        x = np.array(euler(x, u)).ravel()
        guess = shifted(z)
        path.append(x.tolist())
    return {
        "ms": times,
        "cpu_ms": cpu_times,
        "violations": violations,
        "cost": cost,
        "error": float(np.hypot(*(x - GOAL)[:2])),
        "path": path,
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("options", choices=OPTIONS)
    parser.add_argument("--steps", type=int, default=120)
    arguments = parser.parse_args()
    print(json.dumps(drive(OPTIONS[arguments.options], arguments.steps)))

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Script B.2 with alpaqa, an augmented Lagrangian method around PANOC; prints JSON (script_b2.py).

The poses follow from the controls (single shooting): with the poses as variables it needs many times
as long. The squares of the distances are smooth everywhere.

    with_alpaqa.py panoc|zerofpr [--steps N] [--cache DIR]
"""
import os

import alpaqa
import casadi as ca
import numpy as np

import script_b2
from script_b2 import CHANGE, GAP, N, V, W, WORKSPACE

TOLERANCE = 1e-3  # of gradients as they are; the others scale the cost, whose gradient exceeds 100
OUTER = {"tolerance": TOLERANCE, "dual_tolerance": 1e-4, "initial_penalty": 100.0,
         "penalty_update_factor": 5.0, "initial_tolerance": 1.0}
INNER = {"max_iter": 2000}
OPTIONS = {
    "panoc": lambda: alpaqa.PANOCSolver(INNER, alpaqa.StructuredLBFGSDirection({"memory": 30}, {})),
    "zerofpr": lambda: alpaqa.ZeroFPRSolver(INNER, alpaqa.LBFGSDirection({"memory": 30})),
}


def poses(x, U):
    """Poses along the controls."""
    X = [x]
    for u in U:
        X.append(script_b2.euler(X[-1], u))
    return X


def problem():
    U, start = ca.SX.sym("U", 2, N), ca.SX.sym("P", 3)
    controls = ca.horzsplit(U)
    X = poses(start, controls)
    cost = sum(script_b2.stage_cost(x, u) for x, u in zip(X, controls))
    rows = [*[script_b2.distances(x) ** 2 for x in X[1:]], *[x[:2] for x in X[1:]],
            ca.vec(U[:, 1:] - U[:, :-1])]
    sizes = [N * len(script_b2.POLES_X), 2 * N, 2 * (N - 1)]
    lower = np.repeat([GAP**2, -WORKSPACE, -CHANGE], sizes)
    upper = np.repeat([np.inf, WORKSPACE, CHANGE], sizes)
    box = np.tile([V[0], W[0]], N), np.tile([V[1], W[1]], N)
    stated = alpaqa.minimize(cost, ca.vec(U)).subject_to_box(box)
    return stated.subject_to(ca.vertcat(*rows), (lower, upper)).with_param(start, script_b2.START)


class Peer:
    def __init__(self, name, cache):
        os.environ["ALPAQA_CACHE_DIR"] = str(cache / "alpaqa")
        os.environ["CFLAGS"] = " ".join(script_b2.FLAGS)
        self.problem = problem().compile()
        self.solver = alpaqa.ALMSolver(OUTER, OPTIONS[name]())
        self.multipliers = None

    def prepare(self, x, X, U):
        self.problem.param = x
        self.guess = U.ravel().copy()

    def solve(self):
        # In this thread, whose time is taken.
        self.z, self.multipliers, self.end = self.solver(self.problem, self.guess, self.multipliers,
                                                         asynchronous=False)

    def plan(self):
        U = self.z.reshape(N, 2)
        X = np.array([np.array(x).ravel() for x in poses(self.problem.param, U)])
        return X, U, self.end["status"] == alpaqa.SolverStatus.Converged


if __name__ == "__main__":
    script_b2.main(__doc__, OPTIONS, Peer)

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Script B.2 with the fatrop in CasADi's wheel; prints JSON (script_b2.py).

fatrop wants variables and rows stage by stage, and rows that concern one stage only. So a stage's
state has the control before it too, which turns the limits of its change into rows of the stage.

    with_fatrop.py default|best [--steps N] [--cache DIR]
"""
import casadi as ca
import numpy as np

import script_b2
from casadi_nlp import Nlp
from script_b2 import CHANGE, GAP, N, V, W, WORKSPACE

# It starts from the primal guess alone: no option takes multipliers.
OPTIONS = {"default": {}, "best": {"mu_init": 1e-4, "tolerance": 1e-4}}


class Staged:
    """A programme put together stage by stage."""

    def __init__(self):
        self.variables, self.rows, self.is_equality = [], [], []
        self.limits = {"lbx": [], "ubx": [], "lbg": [], "ubg": []}

    def add_variable(self, name, lower, upper):
        self.variables.append(ca.SX.sym(name, len(lower)))
        self.limits["lbx"] += lower
        self.limits["ubx"] += upper
        return self.variables[-1]

    def add_rows(self, rows, lower, upper):
        count = rows.shape[0]
        self.rows.append(rows)
        self.is_equality += [lower == upper] * count
        self.limits["lbg"] += [lower] * count
        self.limits["ubg"] += [upper] * count


def problem():
    """The pose at the start is a parameter, so the first stage has no state."""
    staged, start, cost = Staged(), ca.SX.sym("P", 3), 0
    pose, before = start, None
    for k in range(N):
        u = staged.add_variable(f"u{k}", [V[0], W[0]], [V[1], W[1]])
        cost += script_b2.stage_cost(pose, u)
        following = ca.vertcat(script_b2.euler(pose, u), u) if k < N - 1 else script_b2.euler(pose, u)
        free = [ca.inf] * (following.shape[0] - 2)
        upper = [WORKSPACE, WORKSPACE, *free]
        state = staged.add_variable(f"x{k + 1}", [-limit for limit in upper], upper)
        staged.add_rows(state - following, 0.0, 0.0)
        if before is not None:
            staged.add_rows(script_b2.distances(pose), GAP, ca.inf)
            staged.add_rows(u - before, -CHANGE, CHANGE)
        pose, before = state[:3], state[3:]
    staged.add_rows(script_b2.distances(pose), GAP, ca.inf)
    nlp = {"f": cost, "x": ca.vertcat(*staged.variables), "g": ca.vertcat(*staged.rows), "p": start}
    return nlp, staged


class Peer:
    def __init__(self, name, cache):
        nlp, staged = problem()
        options = {"structure_detection": "auto", "equality": staged.is_equality,
                   "fatrop": {"print_level": 0, **OPTIONS[name]}}
        self.nlp = Nlp("fatrop", nlp, staged.limits, options, cache)
        self.solve = self.nlp.solve

    def prepare(self, x, X, U):
        states = [np.r_[X[k], U[k - 1]] for k in range(1, N)] + [X[N]]
        self.nlp.given["x0"][:] = np.concatenate([part for k in range(N) for part in (U[k], states[k])])
        self.nlp.given["p"][:] = x

    def plan(self):
        z = self.nlp.found["x"]
        each = np.r_[z, 0.0, 0.0].reshape(N, 7)  # u, pose, u again, which the last stage lacks
        return np.vstack([self.nlp.given["p"], each[:, 2:5]]), each[:, :2], self.nlp.succeeded()


if __name__ == "__main__":
    script_b2.main(__doc__, OPTIONS, Peer)

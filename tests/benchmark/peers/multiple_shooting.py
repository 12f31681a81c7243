# SPDX-License-Identifier: Apache-2.0
"""Script B.2 as the script states it: poses, then controls; dynamics, then distances, then changes."""
import casadi as ca
import numpy as np

import script_b2
from casadi_nlp import Nlp
from script_b2 import CHANGE, GAP, N, V, W, WORKSPACE


def problem():
    X, U, P = ca.SX.sym("X", 3, N + 1), ca.SX.sym("U", 2, N), ca.SX.sym("P", 3)
    cost, dynamics = 0, [X[:, 0] - P]
    for k in range(N):
        cost += script_b2.stage_cost(X[:, k], U[:, k])
        dynamics.append(X[:, k + 1] - script_b2.euler(X[:, k], U[:, k]))
    distance = [GAP - script_b2.distances(X[:, k]) for k in range(N + 1)]
    change = [U[:, k + 1] - U[:, k] for k in range(N - 1)]
    rows = [ca.vertcat(*part) for part in (dynamics, distance, change)]
    equal, far, changes = (part.shape[0] for part in rows)
    limits = {
        "lbg": np.r_[np.zeros(equal), np.full(far, -np.inf), np.full(changes, -CHANGE)],
        "ubg": np.r_[np.zeros(equal + far), np.full(changes, CHANGE)],
        "lbx": np.r_[np.tile([-WORKSPACE, -WORKSPACE, -np.inf], N + 1), np.tile([V[0], W[0]], N)],
        "ubx": np.r_[np.tile([WORKSPACE, WORKSPACE, np.inf], N + 1), np.tile([V[1], W[1]], N)],
    }
    nlp = {"f": cost, "x": ca.vertcat(ca.vec(X), ca.vec(U)), "g": ca.vertcat(*rows), "p": P}
    return nlp, limits


class Peer:
    """By a solver of CasADi's."""

    def __init__(self, plugin, options, cache):
        nlp, limits = problem()
        self.nlp = Nlp(plugin, nlp, limits, options, cache)
        self.solve = self.nlp.solve

    def prepare(self, x, X, U):
        self.nlp.given["x0"][:] = np.r_[X.ravel(), U.ravel()]
        self.nlp.given["p"][:] = x

    def plan(self):
        z = self.nlp.found["x"]
        poses = 3 * (N + 1)
        return z[:poses].reshape(N + 1, 3).copy(), z[poses:].reshape(N, 2).copy(), self.nlp.succeeded()

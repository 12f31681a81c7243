#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Script B.2 with Uno, whose package calls functions of Python; these call compiled code and take a few
microseconds. Prints JSON (script_b2.py).

    with_uno.py filtersqp|ipopt [--steps N] [--cache DIR]
"""
import casadi as ca
import numpy as np
import unopy

import multiple_shooting
import script_b2
from casadi_nlp import Compiled
from script_b2 import N

TOLERANCE = 1e-4
OPTIONS = {"filtersqp": {}, "ipopt": {}}  # presets of Uno's


def compiled(nlp, cache):
    """Objective, its gradient, rows, their Jacobian and the Lagrangian's Hessian, all nonzeros."""
    x, p, f, g = nlp["x"], nlp["p"], nlp["f"], nlp["g"]
    sigma, y = ca.SX.sym("sigma"), ca.SX.sym("y", g.shape[0])
    hessian = ca.tril(ca.hessian(sigma * f + ca.dot(y, g), x)[0])
    jacobian = ca.jacobian(g, x)
    functions = [
        ca.Function("f", [x, p], [f]),
        ca.Function("df", [x, p], [ca.densify(ca.gradient(f, x))]),
        ca.Function("g", [x, p], [ca.densify(g)]),
        ca.Function("dg", [x, p], [jacobian]),
        ca.Function("h", [x, p, sigma, y], [hessian]),
    ]
    return Compiled(functions, cache), jacobian.sparsity(), hessian.sparsity()


class Peer:
    def __init__(self, name, cache):
        nlp, limits = multiple_shooting.problem()
        call, jacobian, hessian = compiled(nlp, cache)
        self.pose = np.zeros(3)
        self.model = self.make_model(call, limits, jacobian, hessian, nlp["x"].shape[0])
        self.solver = unopy.UnoSolver()
        self.solver.set_preset(name)
        for option, value in {"logger": "SILENT", "print_solution": False, "primal_tolerance": TOLERANCE,
                              "dual_tolerance": TOLERANCE}.items():
            self.solver.set_option(option, value)
        self.result = None

    def make_model(self, call, limits, jacobian, hessian, count):
        pose = self.pose

        def fill(name):
            return lambda x, out: call(name, out, x, pose)

        def fill_hessian(x, sigma, y, out):
            call("h", out, x, pose, sigma, y)

        def objective(x):
            call("f", self.value, x, pose)
            return self.value[0]

        self.value = np.zeros(1)
        model = unopy.Model(unopy.PROBLEM_NONLINEAR, count, limits["lbx"], limits["ubx"],
                            unopy.ZERO_BASED_INDEXING)
        model.set_objective(unopy.MINIMIZE, objective, fill("df"))
        rows, columns = jacobian.get_triplet()
        model.set_constraints(len(limits["lbg"]), fill("g"), limits["lbg"], limits["ubg"], len(rows), rows,
                              columns, fill("dg"))
        rows, columns = hessian.get_triplet()
        model.set_lagrangian_hessian(len(rows), unopy.LOWER_TRIANGLE, rows, columns, fill_hessian)
        model.set_lagrangian_sign_convention(unopy.MULTIPLIER_POSITIVE)
        return model

    def prepare(self, x, X, U):
        self.pose[:] = x
        self.model.set_initial_primal_iterate(np.r_[X.ravel(), U.ravel()])
        if self.result is not None:
            self.model.set_initial_dual_iterate(np.array(self.result.constraint_dual_solution))

    def solve(self):
        self.result = self.solver.optimize(self.model)

    def plan(self):
        z, poses = np.array(self.result.primal_solution), 3 * (N + 1)
        reached = self.result.solution_status == unopy.SolutionStatus.FEASIBLE_KKT_POINT
        return z[:poses].reshape(N + 1, 3), z[poses:].reshape(N, 2), reached


if __name__ == "__main__":
    script_b2.main(__doc__, OPTIONS, Peer)

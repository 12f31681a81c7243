#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Script B.2 with acados, which generates a solver as C; prints JSON (script_b2.py).

The changes of the controls are acados's controls and the controls are states, so that all limits but
the distances are bounds. Needs ACADOS_SOURCE_DIR and LD_LIBRARY_PATH, which peers.py sets.

    with_acados.py rti|rti_exact|sqp [--steps N] [--cache DIR]
"""
import os
import pathlib

import casadi as ca
import numpy as np
from acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver

import script_b2
from script_b2 import CHANGE, GAP, N, V, W, WORKSPACE

TOLERANCE = 1e-4
FAR = 1e4  # of a distance that has no upper limit
# Gauss-Newton has the exact Hessian of the cost, which is quadratic, but neither the curvature of the
# distances nor that of the motion: with it, SQP does not converge. So `exact` has them too, projected
# to be convex. One iteration a solve is RTI.
GAUSS_NEWTON = {"hessian_approx": "GAUSS_NEWTON"}
EXACT = {"hessian_approx": "EXACT", "regularize_method": "PROJECT"}
QP_TOLERANCE = {f"qp_solver_tol_{kind}": 0.1 * TOLERANCE for kind in ("stat", "eq", "ineq", "comp")}
OPTIONS = {
    "rti": {"nlp_solver_type": "SQP_RTI", **GAUSS_NEWTON},
    "rti_exact": {"nlp_solver_type": "SQP_RTI", **EXACT},
    "sqp": {"nlp_solver_type": "SQP", **EXACT, **QP_TOLERANCE},
}


def model(name):
    out = AcadosModel()
    out.name = name
    out.x, out.u = ca.SX.sym("x", 5), ca.SX.sym("change", 2)
    u = out.x[3:] + out.u
    out.disc_dyn_expr = ca.vertcat(script_b2.euler(out.x[:3], u), u)
    # The stage's control is the next state's, so its cost is that of state and change together.
    out.cost_y_expr_0 = out.cost_y_expr = ca.vertcat(out.x[:3] - script_b2.GOAL, u)
    out.con_h_expr = out.con_h_expr_e = script_b2.distances(out.x)
    return out


def problem(name):
    ocp = AcadosOcp()
    ocp.model = model(name)
    ocp.dims.N = N
    cost = ocp.cost
    cost.cost_type = cost.cost_type_0 = "NONLINEAR_LS"
    cost.W = cost.W_0 = 2 * np.block([[script_b2.Q, np.zeros((3, 2))], [np.zeros((2, 3)), script_b2.R]])
    cost.yref = cost.yref_0 = np.zeros(5)
    add_limits(ocp.constraints)
    return ocp


def add_limits(limits):
    limits.x0 = np.r_[script_b2.START, 0.0, 0.0]
    limits.idxbu, limits.lbu, limits.ubu = np.array([0, 1]), np.full(2, -CHANGE), np.full(2, CHANGE)
    limits.idxbx = limits.idxbx_e = np.array([0, 1, 3, 4])
    limits.lbx = limits.lbx_e = np.array([-WORKSPACE, -WORKSPACE, V[0], W[0]])
    limits.ubx = limits.ubx_e = np.array([WORKSPACE, WORKSPACE, V[1], W[1]])
    poles = len(script_b2.POLES_X)
    limits.lh = limits.lh_e = np.full(poles, GAP)
    limits.uh = limits.uh_e = np.full(poles, FAR)


def choose(options, chosen):
    options.qp_solver = "PARTIAL_CONDENSING_HPIPM"
    options.hpipm_mode = "SPEED"
    options.qp_solver_cond_N = N
    options.qp_solver_warm_start = 1
    options.integrator_type = "DISCRETE"
    options.tf = float(N)  # it weights a stage by its length
    options.ext_fun_compile_flags = " ".join(script_b2.FLAGS)
    for kind in ("stat", "eq", "ineq", "comp"):
        setattr(options, f"nlp_solver_tol_{kind}", TOLERANCE)
    for name, value in chosen.items():
        setattr(options, name, value)


class Peer:
    def __init__(self, name, cache):
        folder = cache / f"acados_{name}"
        folder.mkdir(parents=True, exist_ok=True)
        before = pathlib.Path.cwd()
        os.chdir(folder)
        ocp = problem("script_b2_" + name)
        choose(ocp.solver_options, OPTIONS[name])
        ocp.code_export_directory = str(folder / "code")
        is_built = (folder / "code" / f"libacados_ocp_solver_{ocp.model.name}.so").exists()
        self.solver = AcadosOcpSolver(ocp, "ocp.json", generate=not is_built,
                                      build=not is_built, verbose=False)
        os.chdir(before)
        self.is_rti = OPTIONS[name]["nlp_solver_type"] == "SQP_RTI"
        # The first twist is tied to nothing: from zero it may change to any.
        self.solver.constraints_set(0, "lbu", np.array([V[0], W[0]]))
        self.solver.constraints_set(0, "ubu", np.array([V[1], W[1]]))

    def prepare(self, x, X, U):
        for k in range(N + 1):
            u = np.zeros(2) if k == 0 else U[k - 1]
            self.solver.set(k, "x", np.r_[X[k], u])
            if k < N:
                self.solver.set(k, "u", U[k] - u)
        self.solver.set(0, "lbx", np.r_[x, 0.0, 0.0])
        self.solver.set(0, "ubx", np.r_[x, 0.0, 0.0])

    def solve(self):
        self.status = self.solver.solve()

    def plan(self):
        x = np.array([self.solver.get(k, "x") for k in range(N + 1)])
        if self.is_rti:
            reached = self.solver.get_residuals().max() <= TOLERANCE
        else:
            reached = self.status == 0
        return x[:, :3], x[1:, 3:], reached


if __name__ == "__main__":
    script_b2.main(__doc__, OPTIONS, Peer)

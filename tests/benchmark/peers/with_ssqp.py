#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Script B.2 with SSQP, whose package calls the stages' functions in Python; these call compiled code.
Prints JSON (script_b2.py).

A stage's state has the control before it too, and the control is its change, as with acados.

    with_ssqp.py hpipm [--steps N] [--cache DIR]
"""
import casadi as ca
import numpy as np
import ssqpy

import script_b2
from casadi_nlp import Compiled
from script_b2 import CHANGE, GAP, N, V, W, WORKSPACE

TOLERANCE = 1e-3  # of gradients as they are; the others scale the cost, whose gradient exceeds 100
OPTIONS = {"hpipm": ssqpy.solvers.QPSolverType.HPIPM}  # its ADMM fails at the second iteration
FAR = 1e4
POLES = len(script_b2.POLES_X)
X_SIZE, U_SIZE = 5, 2


def expressions():
    """Name of each function of a stage, and its terms in state x and change u; the last has no u."""
    x, u = ca.SX.sym("x", X_SIZE), ca.SX.sym("u", U_SIZE)
    twist = x[3:] + u
    rows = ca.vertcat(script_b2.distances(x), x[:2], x[3:])
    return x, u, {
        "motion": ca.vertcat(script_b2.euler(x[:3], twist), twist),
        "cost": script_b2.stage_cost(x[:3], twist),
        "first": u,
        "rows": ca.vertcat(rows, u),
        "last": rows,
        "nothing": ca.SX(0),
    }


def functions():
    """Value, Jacobian and the Hessian of each one's product with multipliers."""
    x, u, terms = expressions()
    out = []
    for name, term in terms.items():
        y = ca.SX.sym("y", term.shape[0])
        product = ca.dot(y, term)
        found = {"": term, "_x": ca.jacobian(term, x), "_u": ca.jacobian(term, u),
                 "_xx": ca.hessian(product, x)[0], "_uu": ca.hessian(product, u)[0],
                 "_xu": ca.jacobian(ca.gradient(product, x), u)}
        out += [ca.Function(name + suffix, [x, u, y], [ca.densify(value)])
                for suffix, value in found.items()]
    return out


class Term:
    """One of the functions as SSQP asks for it."""

    def __init__(self, call, name, rows):
        self.call, self.name, self.rows = call, name, rows

    def ask(self, suffix, shape, x, u, y):
        out = np.zeros(int(np.prod(shape)))
        if out.size:
            self.call(self.name + suffix, out, x, u if u.size else np.zeros(U_SIZE), y)
        return out.reshape(shape, order="F")

    def value(self, x, u):
        return self.ask("", (self.rows,), x, u, 0.0)

    def jacobians(self, x, u):
        return (self.ask("_x", (self.rows, X_SIZE), x, u, 0.0),
                self.ask("_u", (self.rows, U_SIZE), x, u, 0.0)[:, : u.size])

    def hessian(self, suffix, x, u, y):
        rows, columns = {"_xx": (X_SIZE, X_SIZE), "_xu": (X_SIZE, U_SIZE), "_uu": (U_SIZE, U_SIZE)}[suffix]
        return self.ask(suffix, (rows, columns), x, u, y)


def methods(hessian):
    """What dynamics, costs and constraints have in common; a class of SSQP's allows one base only.

    `hessian`: SSQP's name for the product with multipliers, of which a cost has none.
    """
    def product(suffix):
        return lambda self, x, u, y=np.ones(1): self.term.hessian(suffix, x, u, y)

    return {
        "evaluate": lambda self, x, u: self.term.value(x, u),
        "gradient": lambda self, x, u: self.term.jacobians(x, u),
        "output_size": lambda self: self.term.rows,
        **{hessian + suffix: product(suffix) for suffix in ("_xx", "_xu", "_uu")},
    }


class Motion(ssqpy.model.dynamics.StageDynamics):
    vars().update(methods("hessprod"))

    def __init__(self, call):
        super().__init__("motion")
        self.term = Term(call, "motion", X_SIZE)

    def state_size(self):
        return X_SIZE

    def control_size(self):
        return U_SIZE

    def state_diff_size(self):
        return X_SIZE


class Cost(ssqpy.model.costs.StageCost):
    vars().update(methods("hessian"))

    def __init__(self, call, name):
        super().__init__(name)
        self.term = Term(call, name, 1)

    def evaluate(self, x, u):
        return float(self.term.value(x, u)[0])

    def gradient(self, x, u):
        by_x, by_u = self.term.jacobians(x, u)
        return by_x[0], by_u[0]


class Limits(ssqpy.model.constraints.StageConstraints):
    vars().update(methods("hessprod"))

    def __init__(self, call, name, lower, upper):
        super().__init__(name)
        self.term = Term(call, name, len(lower))
        self.lower, self.upper = np.array(lower), np.array(upper)

    def lower_bound(self):
        return self.lower

    def upper_bound(self):
        return self.upper

    def constraint_diff_size(self):
        return len(self.lower)


def model(call):
    lower = [GAP] * POLES + [-WORKSPACE, -WORKSPACE, V[0], W[0]]
    upper = [FAR] * POLES + [WORKSPACE, WORKSPACE, V[1], W[1]]
    each = Limits(call, "rows", lower + [-CHANGE] * 2, upper + [CHANGE] * 2)
    first = Limits(call, "first", [V[0], W[0]], [V[1], W[1]])  # tied to nothing: a change from zero
    out = ssqpy.model.Model(N, script_b2.DT)
    out.finalize(stage_cost=Cost(call, "cost"), terminal_cost=Cost(call, "nothing"),
                 constraints=[first] + [each] * (N - 1) + [Limits(call, "last", lower, upper)],
                 dynamics=[Motion(call) for _ in range(N + 1)])
    return out


class Peer:
    def __init__(self, name, cache):
        ssqpy.setSilentMode()
        params = ssqpy.solvers.ssqpParams()
        params.qp_solver_type = OPTIONS[name]
        params.tolerance = TOLERANCE
        self.mpc = ssqpy.solvers.MPC(model(Compiled(functions(), cache)), params, sqp_iters=50,
                                     qp_iters=1000, keep_convergence_data=True)

    def prepare(self, x, X, U):
        before = np.vstack([np.zeros(2), U])
        self.states = [np.r_[X[k], before[k]] for k in range(N + 1)]
        self.states[0][:3] = x
        self.mpc.reinitialize(self.states, list(np.diff(before, axis=0)))

    def solve(self):
        self.found = self.mpc.step(self.states[0])

    def plan(self):
        x = np.array(self.found[0].toarray())
        return x[:, :3], x[1:, 3:], not self.mpc.getConvergenceData()[-1].max_iter_reached


if __name__ == "__main__":
    script_b2.main(__doc__, OPTIONS, Peer)

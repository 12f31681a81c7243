# SPDX-License-Identifier: Apache-2.0
"""A nonlinear programme with one of CasADi's solvers, as fast as CasADi calls it.

The functions are generated as C and compiled once for this processor; the solver is called without
conversions, on arrays that stay in place.
"""
import contextlib
import hashlib
import pathlib
import subprocess
import tempfile

import casadi as ca
import numpy as np

import script_b2

FLAGS = [*script_b2.FLAGS, "-fPIC", "-shared"]


def library(cache, generate):
    """The shared library of the C file that `generate` writes by its name, in the folder `cache`."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        source = pathlib.Path("peer.c")
        generate(source.name)
        key = hashlib.sha256(source.read_bytes() + " ".join(FLAGS).encode()).hexdigest()[:16]
        binary = pathlib.Path(cache) / f"{key}.so"
        if not binary.exists():
            binary.parent.mkdir(parents=True, exist_ok=True)
            subprocess.run(["cc", *FLAGS, source, "-o", binary, "-lm"], check=True)
    return str(binary)


class Compiled:
    """Functions of CasADi's, generated and compiled; arguments and results are copied."""

    def __init__(self, functions, cache):
        code = ca.CodeGenerator("peer.c")
        for function in functions:
            code.add(function)
        binary = library(cache, lambda _: code.generate())
        self._calls = {function.name(): self._call_of(ca.external(function.name(), binary))
                       for function in functions}

    @staticmethod
    def _call_of(function):
        buffer, call = function.buffer()
        given = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        found = np.zeros(function.nnz_out(0))
        for i, values in enumerate(given):
            buffer.set_arg(i, memoryview(values))
        buffer.set_res(0, memoryview(found))
        return buffer, call, given, found

    def __call__(self, name, out, *arguments):
        _, call, given, found = self._calls[name]
        for into, values in zip(given, arguments):
            into[:] = values
        call()
        out[:] = found


class Nlp:
    """`limits`: lbx, ubx, lbg and ubg. `cache`: None leaves the functions to CasADi's interpreter."""

    def __init__(self, plugin, nlp, limits, options, cache=None):
        options = {"print_time": False, "calc_lam_p": False, **options}
        self.solver = ca.nlpsol("solver", plugin, nlp, options)
        if cache:
            binary = library(cache, self.solver.generate_dependencies)
            self.solver = ca.nlpsol("solver", plugin, binary, options)
        self._buffer, self.solve = self.solver.buffer()
        self.given = {}
        for i, name in enumerate(self.solver.name_in()):
            self.given[name] = np.zeros(self.solver.nnz_in(i))
            self.given[name][:] = limits.get(name, 0.0)
            self._buffer.set_arg(i, memoryview(self.given[name]))
        self.found = {}
        for i, name in enumerate(self.solver.name_out()):
            self.found[name] = np.zeros(self.solver.nnz_out(i))
            if self.found[name].size:
                self._buffer.set_res(i, memoryview(self.found[name]))

    def start_from_multipliers(self):
        """Takes those of the last solution as they are."""
        self.given["lam_x0"][:] = self.found["lam_x"]
        self.given["lam_g0"][:] = self.found["lam_g"]

    def succeeded(self):
        return self.solver.stats(1)["success"]  # the buffer's memory is CasADi's second

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Script B.2 with CasADi and the Ipopt in its wheel; prints JSON (script_b2.py).

    with_ipopt.py script|best [--steps N] [--cache DIR]
"""
import multiple_shooting
import script_b2

# The script's options, and the best that were found for the same problem: primal and dual warm
# start, a fixed barrier, a tolerance that fits it, and compiled functions.
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


class Peer(multiple_shooting.Peer):
    def __init__(self, name, cache):
        self.is_best = name == "best"
        super().__init__("ipopt", {"ipopt": {"print_level": 0, "sb": "yes", **OPTIONS[name]}},
                         cache if self.is_best else None)

    def prepare(self, x, X, U):
        super().prepare(x, X, U)
        if self.is_best:
            self.nlp.start_from_multipliers()


if __name__ == "__main__":
    script_b2.main(__doc__, OPTIONS, Peer)

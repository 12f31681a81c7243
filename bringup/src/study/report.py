#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the report of a study: DIR/report.html with all pictures embedded, and DIR/*.png.

Usage: report.py DIR    (reads the files that `tandem study` wrote there: drives.sqlite, summary.json,
                         origins.json, study.json, worlds.json)

The drives are queried, one measure of one group of drives at a time: there may be millions.
"""
import array
import base64
import html
import json
import math
import pathlib
import sqlite3
import statistics
import sys

sys.dont_write_bytecode = True  # the source folder may not be writable
from report_pictures import (STYLES, THESIS_COLLISIONS, THESIS_TIMES,  # noqa: E402
                             collisions_picture, distributions_picture, median, times_picture,
                             world_pictures)


# Whether the map of a drive has the file name :map.
IN_MAP = "(drives.map = :map OR substr(drives.map, -length(:map) - 1) = '/' || :map)"


class Study:
    """The results in a study's folder."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.name = self.read("study.json")["study"]
        self.planned = sum(count_of(group["seeds"]) for group in self.read("study.json")["groups"])
        self.summary = self.read("summary.json")
        self.worlds = self.read("worlds.json")
        self.origins = self.read("origins.json")
        self.methods, self.drivers, self.scenarios = (
            list(dict.fromkeys(g[key] for g in self.summary)) for key in ("method", "driver", "scenario"))
        file = (self.folder / "drives.sqlite").resolve()
        self.database = sqlite3.connect(f"{file.as_uri()}?mode=ro", uri=True)

    def read(self, name):
        return json.loads((self.folder / name).read_text())

    def values(self, expression, only="1", **wanted):
        """The defined values of an expression, as a compact array, of the drives for which `only`
        holds and whose columns have the wanted values."""
        conditions = " AND ".join([only, *(f"{column} = :{column}" for column in wanted)])
        rows = self.database.execute(
            f"SELECT {expression} FROM drives WHERE {conditions} ORDER BY scenario, method, driver, seed",
            wanted)
        return array.array("d", (value for value, in rows if value is not None))

    def count(self, **wanted):
        return sum(g["n"] for g in self.summary if all(g[k] == v for k, v in wanted.items()))

    def total(self, key):
        return sum(g[key] for g in self.summary)

    def tracks(self, scenario, method, map_name, most):
        """Whether the goal was reached, track and contacts of a method's drives in the map of that
        file name: of those with the smallest seeds, `most` at most."""
        rows = self.database.execute(
            "SELECT reached, track, contacts FROM (SELECT scenario, method, driver, seed, reached"
            f" FROM drives WHERE scenario = :scenario AND method = :method AND {IN_MAP}"
            " ORDER BY seed, driver LIMIT :most)"
            " JOIN tracks USING (scenario, method, driver, seed)",
            {"scenario": scenario, "method": method, "map": map_name, "most": most})
        return [(reached, json.loads(track), json.loads(contacts))
                for reached, track, contacts in rows]

    def drives_in(self, scenario, method, map_name):
        """Number of a method's drives in that map, and of their collisions."""
        return self.database.execute(
            "SELECT count(*), sum(collisions) FROM drives"
            f" WHERE scenario = :scenario AND method = :method AND {IN_MAP}",
            {"scenario": scenario, "method": method, "map": map_name}).fetchone()

    def style(self, method):
        return STYLES[self.methods.index(method) % len(STYLES)]


def count_of(seeds):
    """The number of seeds in ranges such as 1-20,25."""
    return sum(int(last or first) - int(first) + 1
               for first, _, last in (part.partition("-") for part in seeds.split(",")))


def number(value, digits=2, unit=""):
    return "–" if value is None else f"{value:.{digits}f}{unit}"


def interval(estimate, digits=2, scale=1.0):
    """HTML text `value [low, high]` of an estimate."""
    if estimate is None:
        return "–"
    value, low, high = (scale * estimate[k] for k in ("value", "low", "high"))
    return f"{value:.{digits}f} <small>[{low:.{digits}f}, {high:.{digits}f}]</small>"

# --- tables --------------------------------------------------------------------------------------


def table(head, rows):
    cells = "".join(f"<th>{h}</th>" for h in head)
    body = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return f"<div class=wide><table><tr>{cells}</tr>{body}</table></div>"


def thesis_table(study, driver):
    rows = []
    for name, collisions, times in (
            ("Devalla 2020: direct", THESIS_COLLISIONS["direct"], THESIS_TIMES["direct"]),
            ("Devalla 2020: shared, untrained", THESIS_COLLISIONS["shared"],
             THESIS_TIMES["shared, untrained"]),
            ("Devalla 2020: shared, trained", None, THESIS_TIMES["shared, trained"])):
        rows.append((name, *collision_cells(collisions), *time_cells(times)))
    for method in study.methods:
        task1 = study.values("collisions", scenario="forest_task1", method=method, driver=driver)
        task2 = study.values("time_to_goal_s", "reached", scenario="forest_task2", method=method,
                             driver=driver)
        if task1 or task2:
            rows.append((html.escape(method), *collision_cells(task1), *time_cells(task2)))
    if len(rows) == 3:
        return ""
    return table(["", "drives of task 1", "collisions", "per drive", "drives of task 2",
                  "mean time", "median time"], rows)


def collision_cells(values):
    if not values:
        return ("–", "–", "–")
    return (len(values), f"{sum(values):.0f}", f"{statistics.fmean(values):.2f}")


def time_cells(values):
    if not values:
        return ("–", "–", "–")
    return (len(values), f"{statistics.fmean(values):.2f} s", f"{median(values):.2f} s")


def scenario_table(study, scenario):
    head = ["method", "driver", "n", "reached", "collisions", "drives with one", "time [s]",
            "÷ free hand", "path ÷ shortest", "closest [m]", "mean clearance [m]", "agreement",
            "… where free", "magnitude", "stuck", "filter changed", "times", "jerk [m/s³]", "SPARC",
            "stick travel [1/s]", "turned back", "reversals of travel", "way to rest [m]",
            "off goal [m]", "askew [°]", "gap at the end [m]"]
    barn = any(g["barn_score"] is not None for g in study.summary if g["scenario"] == scenario)
    if barn:
        head.append("BARN's score")
    rows = []
    for group in study.summary:
        if group["scenario"] != scenario:
            continue
        m = group["medians"]
        share = group["collision_share"]
        rate = group["intervention_rate"]
        rows.append((
            html.escape(group["method"]), html.escape(group["driver"]), group["n"],
            group["reached"], group["collisions"],
            f"{group['drives_with_a_collision']} "
            f"<small>[{100 * share['low']:.0f}, {100 * share['high']:.0f}] %</small>",
            interval(m["time_to_goal_s"], 1), interval(m["time_ratio"]), interval(m["path_ratio"]),
            interval(m["min_clearance_m"], 3), interval(m["mean_clearance_m"]),
            interval(m["agreement_direction"], 3), interval(m["agreement_direction_free"], 3),
            interval(m["agreement_magnitude"]), f"{100 * group['stuck_share']:.1f} %",
            "–" if rate is None else f"{100 * rate:.2f} %", group["intervention_episodes"],
            interval(m["jerk_rms"]), interval(m["spectral_arc_length"]),
            interval(m["stick_travel_per_s"]), interval(m["stick_reversals"], 0),
            interval(m["travel_reversals"], 0), interval(m["way_to_rest_m"]),
            interval(m["final_position_error_m"], 3),
            interval(m["final_heading_error_rad"], 1, 180 / math.pi),
            interval(m["final_clearance_m"], 3)))
        if barn:
            rows[-1] += (number(group["barn_score"], 3),)
    return table(head, rows)


def planner_table(study):
    rows = []
    for group in study.summary:
        ms = group["plan_ms"]
        if ms is None:
            continue
        rows.append((html.escape(group["scenario"]), html.escape(group["method"]),
                     html.escape(group["driver"]), group["plans"],
                     *(number(ms[k], 2) for k in ("p50", "p95", "p99", "max")),
                     group["missed_deadlines"],
                     f"{100 * group['plan_fallbacks'] / max(1, group['plans']):.2f} %"))
    head = ["scenario", "method", "driver", "plans", "p50 [ms]", "p95", "p99", "max",
            "missed deadlines", "fallbacks"]
    return table(head, rows) if rows else ""


# --- the page ------------------------------------------------------------------------------------

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem;
       color: #111; background: #fff; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
table { border-collapse: collapse; font-size: 12.5px; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .5rem; text-align: right; white-space: nowrap;
         border-bottom: 1px solid #ddd; }
th { vertical-align: bottom; border-bottom: 2px solid #111; white-space: normal; }
th:first-child, td:first-child, th:nth-child(2), td:nth-child(2) { text-align: left; }
small { color: #555; } img { max-width: 100%; } .wide { overflow-x: auto; }
"""


def image(file, text):
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<p><img alt="{html.escape(text)}" src="data:image/png;base64,{data}"></p>'


def page(study):
    driver = "navigator" if "navigator" in study.drivers else study.drivers[0]
    drives, collisions = study.total("n"), study.total("collisions")
    missing = study.planned - drives
    builds = {}
    for origin in study.origins:
        builds[origin["build"]] = builds.get(origin["build"], 0) + origin["drives"]
    parts = [
        f"<h1>Study {html.escape(study.name)}</h1>",
        f"<p>{drives} simulated drives, {study.total('simulated_s') / 3600:.1f} hours, "
        f"{collisions} collisions; {len(study.scenarios)} scenarios, {len(study.methods)} methods, "
        f"{len(study.drivers)} drivers."
        + (f" <b>{missing} drives are missing.</b>" if missing else "")
        + (f" <b>Made by {len(builds)} builds of tandem: {', '.join(map(str, builds.values()))} drives.</b>"
           if len(builds) > 1 else "") + "</p>",
        table(["build", "machine", "drives"],
              [(o["build"], html.escape(o["machine"]), o["drives"]) for o in study.origins]),
        "<p>Medians over seeds with bootstrap 95 % confidence intervals in brackets; shares with "
        "Wilson's. Times count drives that arrived. A collision is a contact episode: it ends when "
        "the outline has been clear by 0.05 m for 0.5 s.</p>",
    ]
    thesis = thesis_table(study, driver)
    if thesis:
        parts += ["<h2>Comparison with the thesis</h2>",
                  f"<p>Devalla 2020 (chapters 4 and 5, table C.2: seven people) and the "
                  f"simulated {html.escape(driver)}, a different person for each seed. The thesis "
                  "does not define what counts as one collision.</p>", thesis]
        for file, text in ((collisions_picture(study, driver), "collisions, compared with the thesis"),
                           (times_picture(study, driver), "times, compared with the thesis")):
            if file:
                parts.append(image(file, text))
    paths = world_pictures(study)
    for scenario in study.scenarios:
        parts += [f"<h2>{html.escape(scenario)}</h2>", scenario_table(study, scenario),
                  image(distributions_picture(study, scenario), f"distributions in {scenario}")]
        shown = [key for key in paths if key[0] == scenario]
        worlds, = study.database.execute("SELECT count(DISTINCT map) FROM drives WHERE scenario = ?",
                                         (scenario,)).fetchone()
        if worlds > len(shown):
            parts.append(f"<p>Pictures of {len(shown)} of its {worlds} worlds.</p>")
        parts += [image(paths[key], f"paths in {key[1]}") for key in shown]
    planner = planner_table(study)
    if planner:
        parts += ["<h2>The planner</h2><p>Medians over drives of each drive's quantiles, and the "
                  "maximum over all drives. A plan that takes longer than the control period misses its "
                  "deadline.</p>", planner]
    return (f"<!doctype html><html lang=en><meta charset=utf-8><title>Study "
            f"{html.escape(study.name)}</title><style>{STYLE}</style>" + "\n".join(parts))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    study = Study(sys.argv[1])
    if not study.summary:
        sys.exit(f"{study.folder}: no drive is finished yet")
    file = study.folder / "report.html"
    file.write_text(page(study))
    print(f"report: {file}")


if __name__ == "__main__":
    main()

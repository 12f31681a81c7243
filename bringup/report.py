#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The report of a study: DIR/report.html, which holds everything, and its pictures as DIR/*.png.

Usage: report.py DIR    (what `tandem study` left there: drives.jsonl, drives.json, summary.json,
                         study.json, worlds.json)
"""
import base64
import html
import json
import math
import pathlib
import statistics
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.patches import Circle, Polygon, Rectangle  # noqa: E402
from matplotlib.collections import PatchCollection  # noqa: E402

# Devalla 2020, table C.2: seven people; the fourth did not drive the third time.
THESIS_COLLISIONS = {"direct": [3, 10, 2, 4, 3, 3, 4], "shared": [0] * 7}
THESIS_TIMES = {
    "direct": [16.17, 19.52, 16.33, 20.84, 17.27, 19.98, 17.13],
    "shared, untrained": [19.54, 19.49, 19.50, 19.00, 20.36, 18.08, 19.70],
    "shared, trained": [17.72, 19.39, 17.63, 16.24, 19.03, 18.61],
}

# Colours that the colour-blind tell apart (Okabe, Ito), and with each a marker, a hatch and a line
# for those who print in grey.
STYLES = [
    ("#000000", "o", "", "-"),
    ("#E69F00", "s", "////", "--"),
    ("#0072B2", "^", "....", "-."),
    ("#009E73", "D", "\\\\\\\\", ":"),
    ("#D55E00", "v", "xxxx", (0, (5, 1))),
    ("#56B4E9", "P", "----", (0, (3, 1, 1, 1))),
    ("#CC79A7", "X", "++++", (0, (1, 1))),
    ("#8A7F00", "<", "oooo", (0, (6, 2, 1, 2))),
    ("#777777", ">", "||||", (0, (2, 2))),
    ("#3B528B", "*", "**", (0, (4, 1, 1, 1, 1, 1))),
]
PAPER = "#f2f2f2"

plt.rcParams.update(
    {
        "font.size": 9,
        "axes.titlesize": 10,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "hatch.linewidth": 0.6,
        "savefig.dpi": 130,
        "savefig.bbox": "tight",
    }
)


class Study:
    """What the folder holds."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.name = self.read("study.json")["study"]
        self.planned = len(self.read("study.json")["drives"])
        self.drives = self.read("drives.json")
        self.summary = self.read("summary.json")
        self.worlds = self.read("worlds.json")
        self.methods = list(dict.fromkeys(d["method"] for d in self.drives))
        self.drivers = list(dict.fromkeys(d["driver"] for d in self.drives))
        self.scenarios = list(dict.fromkeys(d["scenario"] for d in self.drives))

    def read(self, name):
        return json.loads((self.folder / name).read_text())

    def tracks(self):
        """Drive, track and contacts of each line; the order is that of finishing."""
        with open(self.folder / "drives.jsonl", encoding="utf-8") as lines:
            for line in lines:
                entry = json.loads(line)
                yield entry["drive"], entry["track"], entry["contacts"]

    def of(self, **wanted):
        return [d for d in self.drives if all(d[k] == v for k, v in wanted.items())]

    def style(self, method):
        return STYLES[self.methods.index(method) % len(STYLES)]


def number(value, digits=2, unit=""):
    return "–" if value is None else f"{value:.{digits}f}{unit}"


def interval(estimate, digits=2, scale=1.0):
    """value [low, high]"""
    if estimate is None:
        return "–"
    value, low, high = (scale * estimate[k] for k in ("value", "low", "high"))
    return f"{value:.{digits}f} <small>[{low:.{digits}f}, {high:.{digits}f}]</small>"


def median(values):
    return statistics.median_low(values) if values else None


def save(figure, study, name):
    file = study.folder / f"{name}.png"
    figure.savefig(file)
    plt.close(figure)
    return file


# --- pictures ------------------------------------------------------------------------------------


def strip(axes, row, values, style, label):
    """All values of one row as markers, side by side where they are equal; a bar at the median."""
    color, marker, _, _ = style
    seen = {}
    spread = max(values, default=0) - min(values, default=0) or 1.0
    for value in sorted(values):
        bucket = round(60.0 * value / spread) if spread else 0
        count = seen[bucket] = seen.get(bucket, 0) + 1
        side = (count // 2) * (1 if count % 2 else -1)
        axes.plot(value, row + max(-0.34, min(0.34, 0.055 * side)), marker=marker, color=color,
                  markerfacecolor="none", markersize=4.5, linestyle="none", alpha=0.8)
    if values:
        middle = median(values)
        axes.plot([middle, middle], [row - 0.38, row + 0.38], color="black", linewidth=2,
                  zorder=1, alpha=0.6)
    axes.text(1.01, row, label, transform=axes.get_yaxis_transform(), va="center", fontsize=8)


def beside_thesis(study, file, title, xlabel, thesis, ours, summary):
    """Rows of the thesis above rows of ours, all values shown."""
    rows = [(f"thesis: {name}", values, STYLES[0]) for name, values in thesis.items()]
    rows += [(method, values, study.style(method)) for method, values in ours.items()]
    figure, axes = plt.subplots(figsize=(7.5, 0.42 * len(rows) + 1.0))
    for i, (_, values, style) in enumerate(rows):
        if i < len(thesis):
            axes.axhspan(i - 0.5, i + 0.5, color=PAPER, zorder=-2)
        strip(axes, i, values, style, summary(values))
    axes.set_yticks(range(len(rows)), [name for name, _, _ in rows])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlabel(xlabel)
    axes.set_title(title, loc="left")
    axes.grid(axis="x", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    return save(figure, study, file)


def collisions_picture(study, driver):
    ours = {m: [d["collisions"] for d in study.of(scenario="forest_task1", method=m, driver=driver)]
            for m in study.methods}
    ours = {m: values for m, values in ours.items() if values}
    if not ours:
        return None
    return beside_thesis(
        study, "thesis_collisions", "Task 1: two minutes at will in the forest",
        "collisions of a drive; the bar is the median", THESIS_COLLISIONS, ours,
        lambda v: f"{sum(v)} in {len(v)} drives, mean {statistics.mean(v):.2f}")


def times_picture(study, driver):
    ours = {m: [d["time_to_goal_s"] for d in study.of(scenario="forest_task2", method=m,
                                                      driver=driver) if d["reached"]]
            for m in study.methods}
    ours = {m: values for m, values in ours.items() if values}
    if not ours:
        return None
    return beside_thesis(
        study, "thesis_times", "Task 2: from the start to the marked region",
        "time to the region [s]; the bar is the median", THESIS_TIMES, ours,
        lambda v: f"mean {statistics.mean(v):.2f} s, n = {len(v)}")


DISTRIBUTIONS = [
    ("time_ratio", "time / time by hand without obstacles"),
    ("min_clearance_m", "smallest clearance [m]"),
    ("agreement_direction", "agreement of direction"),
    ("jerk_rms", "jerk [m/s³], rms"),
]


def distributions_picture(study, scenario):
    drives = study.of(scenario=scenario)
    methods = [m for m in study.methods if any(d["method"] == m for d in drives)]
    figure, all_axes = plt.subplots(1, len(DISTRIBUTIONS), figsize=(11, 0.34 * len(methods) + 1.1),
                                    sharey=True)
    for axes, (key, label) in zip(all_axes, DISTRIBUTIONS):
        for row, method in enumerate(methods):
            values = [d[key] for d in drives if d["method"] == method and d[key] is not None]
            if not values:
                axes.text(0.5, row, "none", transform=axes.get_yaxis_transform(), ha="center",
                          va="center", fontsize=7, color="#666666")
                continue
            color, _, hatch, _ = study.style(method)
            box = axes.boxplot([values], positions=[row], vert=False, widths=0.6,
                               patch_artist=True, flierprops={"marker": ".", "markersize": 3},
                               medianprops={"color": "black", "linewidth": 2})
            for patch in box["boxes"]:
                patch.set(facecolor="white", edgecolor=color, hatch=hatch)
        axes.set_xlabel(label, fontsize=8)
        axes.grid(axis="x", color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
    all_axes[0].set_yticks(range(len(methods)), methods)
    all_axes[0].set_ylim(len(methods) - 0.5, -0.5)
    figure.suptitle(f"{scenario}: {len(drives)} drives of all drivers and seeds", x=0.01,
                    ha="left", fontsize=10)
    figure.tight_layout()
    return save(figure, study, f"distributions_{scenario}")


def draw_scene(axes, scene, world):
    half = 0.5 * world["resolution"]
    cells = [Rectangle((x - half, y - half), 2 * half, 2 * half) for x, y in world["cells"]]
    axes.add_collection(PatchCollection(cells, facecolor="#8a8a8a", edgecolor="none"))
    goal = {"facecolor": "none", "edgecolor": "black", "linewidth": 0.9, "linestyle": "--"}
    if "region" in scene["goal"]:
        x1, y1, x2, y2 = scene["goal"]["region"]
        axes.add_patch(Rectangle((x1, y1), x2 - x1, y2 - y1, **goal))
    one = [scene["goal"]["pose"]] if "pose" in scene["goal"] else []
    for x, y, _ in scene["goal"].get("poses", one):
        axes.add_patch(Circle((x, y), scene["goal"]["tolerance"], **goal))
    x, y, theta = scene["start"]
    c, s = math.cos(theta), math.sin(theta)
    left, bottom = min(p[0] for p in world["cells"]), min(p[1] for p in world["cells"])
    axes.plot([left, left + 1.0], [bottom - 0.25] * 2, color="black", linewidth=1.2)
    axes.text(left + 1.1, bottom - 0.25, "1 m", fontsize=6, va="center")
    axes.add_patch(Polygon([(x + c * u - s * v, y + s * u + c * v) for u, v in scene["outline"]],
                           facecolor="none", edgecolor="black", linewidth=0.9))


def limits(scene, world, tracks):
    points = world["cells"] + [scene["start"][:2]] + [p for t in tracks for p in t]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs) - 0.2, max(xs) + 0.2, min(ys) - 0.45, max(ys) + 0.2


def world_picture(study, scenario, world_name, drives):
    """All paths through one world, a panel for each method."""
    scene = study.worlds[scenario]
    world = scene["worlds"][world_name]
    methods = [m for m in study.methods if m in drives]
    x1, x2, y1, y2 = limits(scene, world, [t for d in drives.values() for _, t, _ in d])
    across = min(len(methods), 4 if x2 - x1 < 1.8 * (y2 - y1) else 2)
    down = math.ceil(len(methods) / across)
    width = min(3.0, 12.0 / across)
    width = 12.0 / across if across == 2 else width
    height = width * (y2 - y1) / (x2 - x1)
    figure, grid = plt.subplots(down, across, figsize=(across * width, down * (height + 0.35)),
                                squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for axes, method in zip(grid.flat, methods):
        color, _, _, _ = study.style(method)
        draw_scene(axes, scene, world)
        touches = 0
        for drive, track, contacts in drives[method]:
            axes.plot([p[0] for p in track], [p[1] for p in track], color=color, linewidth=0.7,
                      linestyle="-" if drive["reached"] else ":", alpha=0.7)
            touches += drive["collisions"]
            axes.plot([p[0] for p in contacts], [p[1] for p in contacts], "x", color="black",
                      markersize=6, markeredgewidth=1.6, zorder=5)
        axes.set(xlim=(x1, x2), ylim=(y1, y2), aspect="equal")
        axes.set_title(f"{method}: {len(drives[method])} drives, {touches} collisions", fontsize=8)
    where = scenario if len(scene["worlds"]) == 1 else f"{scenario}, {world_name}"
    figure.suptitle(f"{where}    × collision    dotted: did not arrive    dashed: goal", x=0.01,
                    ha="left", fontsize=9)
    figure.tight_layout()
    stem = pathlib.Path(world_name).stem
    return save(figure, study, f"paths_{scenario}" + ("" if stem == scenario else f"_{stem}"))


def world_pictures(study):
    by_world = {}
    for drive, track, contacts in study.tracks():
        world = pathlib.Path(drive["map"]).name
        if world in study.worlds.get(drive["scenario"], {"worlds": {}})["worlds"]:
            methods = by_world.setdefault((drive["scenario"], world), {})
            methods.setdefault(drive["method"], []).append((drive, track, contacts))
    order = sorted(by_world, key=lambda k: (study.scenarios.index(k[0]), k[1]))
    return {key: world_picture(study, *key, by_world[key]) for key in order}


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
        task1 = [d["collisions"] for d in study.of(scenario="forest_task1", method=method,
                                                   driver=driver)]
        task2 = [d["time_to_goal_s"] for d in study.of(scenario="forest_task2", method=method,
                                                       driver=driver) if d["reached"]]
        if task1 or task2:
            rows.append((html.escape(method), *collision_cells(task1), *time_cells(task2)))
    if len(rows) == 3:
        return ""
    return table(["", "drives of task 1", "collisions", "per drive", "drives of task 2",
                  "mean time", "median time"], rows)


def collision_cells(values):
    if not values:
        return ("–", "–", "–")
    return (len(values), sum(values), f"{statistics.mean(values):.2f}")


def time_cells(values):
    if not values:
        return ("–", "–", "–")
    return (len(values), f"{statistics.mean(values):.2f} s", f"{median(values):.2f} s")


def scenario_table(study, scenario):
    head = ["method", "driver", "n", "reached", "collisions", "drives with one", "time [s]",
            "÷ free hand", "path ÷ shortest", "closest [m]", "mean clearance [m]", "agreement",
            "… where free", "magnitude", "stuck", "filter changed", "times", "jerk [m/s³]", "SPARC",
            "stick travel [1/s]", "turned back"]
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
            interval(m["stick_travel_per_s"]), interval(m["stick_reversals"], 0)))
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
    collisions = sum(d["collisions"] for d in study.drives)
    simulated = sum(d["simulated_s"] for d in study.drives)
    missing = study.planned - len(study.drives)
    parts = [
        f"<h1>Study {html.escape(study.name)}</h1>",
        f"<p>{len(study.drives)} simulated drives, {simulated / 3600:.1f} hours, "
        f"{collisions} collisions; {len(study.scenarios)} scenarios, {len(study.methods)} methods, "
        f"{len(study.drivers)} drivers."
        + (f" <b>{missing} drives are still to be made.</b>" if missing else "") + "</p>",
        "<p>Medians over seeds with bootstrap 95 % confidence intervals in brackets; shares with "
        "Wilson's. Times count drives that arrived. A collision is a contact episode: it ends when "
        "the outline has been clear by 0.05 m for 0.5 s.</p>",
    ]
    thesis = thesis_table(study, driver)
    if thesis:
        parts += ["<h2>Beside the thesis</h2>",
                  f"<p>Devalla 2020 (chapters 4 and 5, table C.2: seven people) beside the "
                  f"simulated {html.escape(driver)}, each seed another person. The thesis gives no "
                  "rule for what counts as one collision.</p>", thesis]
        for file, text in ((collisions_picture(study, driver), "collisions beside the thesis"),
                           (times_picture(study, driver), "times beside the thesis")):
            if file:
                parts.append(image(file, text))
    paths = world_pictures(study)
    for scenario in study.scenarios:
        parts += [f"<h2>{html.escape(scenario)}</h2>", scenario_table(study, scenario),
                  image(distributions_picture(study, scenario), f"distributions in {scenario}")]
        shown = [key for key in paths if key[0] == scenario]
        worlds = len({d["map"] for d in study.of(scenario=scenario)})
        if worlds > len(shown):
            parts.append(f"<p>Pictures of {len(shown)} of its {worlds} worlds.</p>")
        parts += [image(paths[key], f"paths in {key[1]}") for key in shown]
    planner = planner_table(study)
    if planner:
        parts += ["<h2>The planner</h2><p>Medians over drives of each drive's quantiles; the "
                  "longest of all. A plan that takes longer than the control period misses its "
                  "deadline.</p>", planner]
    return (f"<!doctype html><html lang=en><meta charset=utf-8><title>Study "
            f"{html.escape(study.name)}</title><style>{STYLE}</style>" + "\n".join(parts))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    study = Study(sys.argv[1])
    if not study.drives:
        sys.exit(f"{study.folder}: no drive is finished yet")
    file = study.folder / "report.html"
    file.write_text(page(study))
    print(f"report: {file}")


if __name__ == "__main__":
    main()

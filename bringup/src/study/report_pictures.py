# SPDX-License-Identifier: Apache-2.0
"""Draws the pictures of a study's report as PNG files in the study's folder."""
import math
import pathlib
import statistics

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.patches import Circle, Polygon, Rectangle  # noqa: E402
from matplotlib.collections import PatchCollection  # noqa: E402

# Devalla 2020, table C.2: seven people; the fourth did not drive "shared, trained".
THESIS_COLLISIONS = {"direct": [3, 10, 2, 4, 3, 3, 4], "shared": [0] * 7}
THESIS_TIMES = {
    "direct": [16.17, 19.52, 16.33, 20.84, 17.27, 19.98, 17.13],
    "shared, untrained": [19.54, 19.49, 19.50, 19.00, 20.36, 18.08, 19.70],
    "shared, trained": [17.72, 19.39, 17.63, 16.24, 19.03, 18.61],
}

# Colours that colour-blind readers can distinguish (Okabe, Ito), each with a marker, a hatch and a
# line style for prints in grey.
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
MAX_MARKERS, MAX_PATHS = 300, 100  # drawn of one method

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


def median(values):
    return statistics.median_low(values) if values else None


def save(figure, study, name):
    file = study.folder / f"{name}.png"
    figure.savefig(file)
    plt.close(figure)
    return file


def strip(axes, row, values, style, label):
    """Draws one row of values as markers, stacked where they are equal, and a bar at the median. Of
    very many values only the first are drawn."""
    color, marker, _, _ = style
    seen = {}
    spread = max(values, default=0) - min(values, default=0) or 1.0
    for value in sorted(values[:MAX_MARKERS]):
        bucket = round(60.0 * value / spread) if spread else 0
        count = seen[bucket] = seen.get(bucket, 0) + 1
        side = (count // 2) * (1 if count % 2 else -1)
        axes.plot(value, row + max(-0.34, min(0.34, 0.055 * side)), marker=marker, color=color,
                  markerfacecolor="none", markersize=4.5, linestyle="none", alpha=0.8)
    if values:
        middle = median(values)
        axes.plot([middle, middle], [row - 0.38, row + 0.38], color="black", linewidth=2,
                  zorder=1, alpha=0.6)
    if len(values) > MAX_MARKERS:
        label += f" ({MAX_MARKERS} drawn)"
    axes.text(1.01, row, label, transform=axes.get_yaxis_transform(), va="center", fontsize=8)


def beside_thesis(study, file, title, xlabel, thesis, ours, summary):
    """Draws all values of the thesis, and below them those of the study."""
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
    ours = {m: study.values("collisions", scenario="forest_task1", method=m, driver=driver)
            for m in study.methods}
    ours = {m: values for m, values in ours.items() if values}
    if not ours:
        return None
    return beside_thesis(
        study, "thesis_collisions", "Task 1: two minutes of free driving in the forest",
        "collisions of a drive; the bar is the median", THESIS_COLLISIONS, ours,
        lambda v: f"{sum(v):.0f} in {len(v)} drives, mean {statistics.fmean(v):.2f}")


def times_picture(study, driver):
    ours = {m: study.values("time_to_goal_s", "reached", scenario="forest_task2", method=m,
                            driver=driver) for m in study.methods}
    ours = {m: values for m, values in ours.items() if values}
    if not ours:
        return None
    return beside_thesis(
        study, "thesis_times", "Task 2: from the start to the marked region",
        "time to the region [s]; the bar is the median", THESIS_TIMES, ours,
        lambda v: f"mean {statistics.fmean(v):.2f} s, n = {len(v)}")


DISTRIBUTIONS = [
    ("time_ratio", "time / time by hand without obstacles"),
    ("min_clearance_m", "smallest clearance [m]"),
    ("agreement_direction", "agreement of direction"),
    ("jerk_rms", "jerk [m/s³], rms"),
]


def distributions_picture(study, scenario):
    methods = [m for m in study.methods if study.count(scenario=scenario, method=m)]
    figure, all_axes = plt.subplots(1, len(DISTRIBUTIONS), figsize=(11, 0.34 * len(methods) + 1.1),
                                    sharey=True)
    for axes, (key, label) in zip(all_axes, DISTRIBUTIONS):
        for row, method in enumerate(methods):
            values = study.values(key, scenario=scenario, method=method)
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
    figure.suptitle(f"{scenario}: {study.count(scenario=scenario)} drives of all drivers and seeds", x=0.01,
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
    for part in outline_parts(scene):
        axes.add_patch(Polygon([(x + c * u - s * v, y + s * u + c * v) for u, v in part],
                               facecolor="none", edgecolor="black", linewidth=0.9))


def outline_parts(scene):
    """The outline's convex parts. Folders of older versions hold the vertices of a single part."""
    outline = scene["outline"]
    return outline if isinstance(outline[0][0], list) else [outline]


def limits(scene, world, tracks):
    points = world["cells"] + [scene["start"][:2]] + [p for t in tracks for p in t]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs) - 0.2, max(xs) + 0.2, min(ys) - 0.45, max(ys) + 0.2


def world_picture(study, scenario, world_name, drives):
    """Draws the paths through one world, with a panel per method. `drives`: by method."""
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
        for reached, track, contacts in drives[method]:
            axes.plot([p[0] for p in track], [p[1] for p in track], color=color, linewidth=0.7,
                      linestyle="-" if reached else ":", alpha=0.7)
            axes.plot([p[0] for p in contacts], [p[1] for p in contacts], "x", color="black",
                      markersize=6, markeredgewidth=1.6, zorder=5)
        axes.set(xlim=(x1, x2), ylim=(y1, y2), aspect="equal")
        count, touches = study.drives_in(scenario, method, world_name)
        drawn = f" ({MAX_PATHS} drawn)" if count > MAX_PATHS else ""
        axes.set_title(f"{method}: {count} drives{drawn}, {touches} collisions", fontsize=8)
    where = scenario if len(scene["worlds"]) == 1 else f"{scenario}, {world_name}"
    figure.suptitle(f"{where}    × collision    dotted: did not arrive    dashed: goal", x=0.01,
                    ha="left", fontsize=9)
    figure.tight_layout()
    stem = pathlib.Path(world_name).stem
    return save(figure, study, f"paths_{scenario}" + ("" if stem == scenario else f"_{stem}"))


def world_pictures(study):
    pictures = {}
    for scenario in study.scenarios:
        for world in sorted(study.worlds.get(scenario, {"worlds": {}})["worlds"]):
            drives = {m: study.tracks(scenario, m, world, MAX_PATHS) for m in study.methods}
            drives = {m: own for m, own in drives.items() if own}
            if drives:
                pictures[scenario, world] = world_picture(study, scenario, world, drives)
    return pictures

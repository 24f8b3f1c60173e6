#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gathers the benchmarks' results: bench/report.py FOLDER reads FOLDER/NAME.json and writes
FOLDER/summary.json, the summaries by name, and FOLDER/report.html, a page by itself with plots and
all rows. Standard library only."""

import base64
import html
import json
import math
import pathlib
import sys

# Okabe and Ito: told apart with any colour vision.
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999"]
ABOUT = ["device", "driver", "compiler", "commit", "cores", "load_before", "repetitions", "quick"]
STYLE = """body{font:14px sans-serif;max-width:1000px;margin:2em auto;color:#222}
h2{margin-top:2em;border-bottom:1px solid #ccc}table{border-collapse:collapse;margin:.5em 0}
td,th{padding:1px 8px;text-align:right;border-bottom:1px solid #eee}
td:first-child,th:first-child{text-align:left}figure{margin:1em 0}
img{image-rendering:pixelated;max-width:100%}svg{display:block;margin:1em 0}
svg text{font:11px sans-serif;fill:#222}"""


def number(value):
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def table(head, rows):
    lines = ["<tr>" + "".join(f"<th>{html.escape(c)}</th>" for c in head) + "</tr>"]
    lines += [
        "<tr>" + "".join(f"<td>{html.escape(number(c))}</td>" for c in row) + "</tr>"
        for row in rows
    ]
    return "<table>\n" + "\n".join(lines) + "\n</table>\n"


def split(row):
    """What a row is about, and which of its kind it is: the last part of the case."""
    what, _, kind = row["case"].rpartition(", ")
    return what, kind


def text(x, y, words, anchor="start"):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{html.escape(words)}</text>'


def svg(width, height, parts):
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )


def legend(names, x, y):
    parts = []
    for i, name in enumerate(names):
        parts.append(
            f'<rect x="{x}" y="{y + 16 * i - 9}" width="10" height="10" fill="{COLOURS[i % len(COLOURS)]}"/>'
        )
        parts.append(text(x + 15, y + 16 * i, name))
    return parts


class Axis:
    """A logarithmic axis from pixel `first` to pixel `last` over the values, and a little more."""

    def __init__(self, values, first, last):
        self.low, self.high = math.log10(min(values)), math.log10(max(values))
        margin = max(
            0.02, (0.5 - (self.high - self.low)) / 2
        )  # half a decade at least: no noise looks like a trend
        self.low, self.high = self.low - margin, self.high + margin
        self.first, self.last = first, last

    def at(self, value):
        return self.first + (self.last - self.first) * (math.log10(value) - self.low) / (
            self.high - self.low
        )

    def ticks(self):
        """Round values, few: decades alone where there are many."""
        steps = [1, 2, 5] if self.high - self.low < 3 else [1]
        every = [
            s * 10.0**d
            for d in range(math.floor(self.low), math.ceil(self.high) + 1)
            for s in steps
        ]
        return [v for v in every if self.low - 1e-9 <= math.log10(v) <= self.high + 1e-9]


def dots(rows, title):
    """Ratios, a line a case: right of 1 is where ours is better."""
    rows = [r for r in rows if r["ratio"] and r["ratio"] > 0]
    if not rows:
        return ""
    kinds = list(dict.fromkeys(split(r)[1] for r in rows))
    cases = list(dict.fromkeys(split(r)[0] for r in rows))
    left, right, top = 280, 760, 30
    bottom = top + 14 * len(cases) + 6
    axis = Axis([r["ratio"] for r in rows] + [0.8, 1.25], left, right)
    parts = [text(left, 14, title)]
    for tick in axis.ticks():
        stroke = "#888" if tick == 1 else "#ddd"
        parts.append(f'<path d="M{axis.at(tick):.1f} {top}V{bottom}" stroke="{stroke}"/>')
        parts.append(text(axis.at(tick), bottom + 13, f"{tick:g}", "middle"))
    parts += [text(left - 6, top + 14 * i + 14, case, "end") for i, case in enumerate(cases)]
    for row in rows:
        what, kind = split(row)
        colour = COLOURS[kinds.index(kind) % len(COLOURS)]
        y = top + 14 * cases.index(what) + 10
        hint = html.escape(f'{row["case"]}: {number(row["ratio"])}')
        parts.append(
            f'<circle cx="{axis.at(row["ratio"]):.1f}" cy="{y}" r="4" fill="{colour}">'
            f"<title>{hint}</title></circle>"
        )
    return svg(
        1000,
        max(bottom + 20, top + 16 * len(kinds) + 10),
        parts + legend(kinds, right + 20, top + 10),
    )


def lines(series, title, x_label, dashed=0):
    """series: name to points (x, y), both axes logarithmic; so many of the last are dashed, to show
    what they cover."""
    series = {
        name: [(x, y) for x, y in points if x and y and x > 0 and y > 0]
        for name, points in series.items()
    }
    points = [p for line in series.values() for p in line]
    if not points:
        return ""
    left, right, top, bottom = 60, 560, 30, 270
    across, up = Axis([p[0] for p in points], left, right), Axis(
        [p[1] for p in points], bottom, top
    )
    parts = [text(left, 16, title), text((left + right) / 2, bottom + 32, x_label, "middle")]
    for tick in across.ticks():
        parts.append(f'<path d="M{across.at(tick):.1f} {top}V{bottom}" stroke="#ddd"/>')
        parts.append(text(across.at(tick), bottom + 14, f"{tick:g}", "middle"))
    for tick in up.ticks():
        parts.append(f'<path d="M{left} {up.at(tick):.1f}H{right}" stroke="#ddd"/>')
        parts.append(text(left - 5, up.at(tick) + 4, f"{tick:g}", "end"))
    for i, line in enumerate(series.values()):
        colour = COLOURS[i % len(COLOURS)]
        places = [(across.at(x), up.at(y)) for x, y in line]
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        dashes = ' stroke-dasharray="6 6"' if i >= len(series) - dashed else ""
        parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"{dashes}/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in places]
    return svg(1000, bottom + 44, parts + legend(series, right + 20, top + 10))


def bars(rows, title):
    """The stages' shares of a launch, a bar a scene."""
    scenes = {}
    for row in rows:
        what, kind = split(row)
        if "items" in row and kind != "whole launch":
            scenes.setdefault(what, {})[kind] = row["ours"]
    kinds = list(dict.fromkeys(k for stages in scenes.values() for k in stages))
    left, width, top = 280, 480, 24
    parts = [text(left, 14, title)]
    for i, (scene, stages) in enumerate(scenes.items()):
        x, total = left, sum(stages.values())
        parts.append(text(left - 6, top + 16 * i + 11, scene, "end"))
        for kind, seconds in stages.items():
            share = width * seconds / total
            colour = COLOURS[kinds.index(kind) % len(COLOURS)]
            hint = html.escape(f"{scene}, {kind}: {seconds:.3g} s")
            parts.append(
                f'<rect x="{x:.1f}" y="{top + 16 * i}" width="{share:.1f}" height="13"'
                f' fill="{colour}"><title>{hint}</title></rect>'
            )
            x += share
    height = max(top + 16 * len(scenes), top + 16 * len(kinds)) + 10
    return svg(1000, height, parts + legend(kinds, left + width + 20, top + 10)) if scenes else ""


def plots_of_error(rows):
    plots = ""
    for scene in dict.fromkeys(r["case"].split(", ")[0] for r in rows):
        for x in ("samples", "seconds"):
            series = {}
            for row in rows:
                name, kind = row["case"].split(", ")[:2]
                if name == scene:
                    series.setdefault(kind, []).append((row[x], row["ours"]))
            plots += lines(series, f"{scene}: RMSE / mean", x)
    return plots


def plots_of_scale(rows):
    plots = ""
    for x in ("triangles", "bounces", "pixels", "samples"):
        chosen = [r for r in rows if x in r]
        series = {"rendering [ns]": [(r[x], r["nanoseconds"]) for r in chosen]}
        if any("setup_seconds" in r for r in chosen):
            series["set-up per triangle [ns]"] = [
                (r[x], r["setup_nanoseconds_per_triangle"]) for r in chosen
            ]
        unit = "ray" if chosen and chosen[0]["unit"] == "Mrays/s" else "sample"
        plots += lines(series, f"Nanoseconds per {unit}", x)
    chosen = [r for r in rows if "threads" in r]
    return plots + lines(
        {"speed-up": [(r["threads"], r["ratio"]) for r in chosen]}, "Speed-up", "threads"
    )


def plots_of_stages(rows):
    shares = [r for r in rows if "render share" in r["case"]]
    stages = [r for r in rows if "items" in r]
    return (
        bars(rows, "Where the time of a launch goes (tile schedule)")
        + dots(stages, "Seconds of the stream schedule over those of the tile schedule")
        + dots(shares, "Rays per second in a render over those of the bare traversal")
    )


def plots_of_build(rows):
    by_unit = [dict(r, case=f'{split(r)[0]} [{r["unit"]}], {split(r)[1]}') for r in rows]
    return dots(by_unit, "Embree over ours, or ours over Embree: right of 1 ours is better")


def scene_of(row):
    return row["case"].split(", ")[0]


def pictures_of_render(row):
    """Ours, theirs and the truth side by side, from the file beside the results."""
    sides = [("MC ViSi", "picture_", "ours"), ("Mitsuba", "peer_picture_", "peer")]
    words = [
        f"{who}: {row[key + 'samples']:.0f} samples, {row[key + 'seconds']:.2g} s, RMSE "
        f"{100 * row[side]:.2g} %"
        for who, key, side in sides
    ]
    return (
        f'<figure><img src="{row["picture"]}" alt="{html.escape(row["case"])}"/>'
        f'<figcaption>{"; ".join(words)}; truth</figcaption></figure>\n'
    )


def plots_of_render(rows):
    """For each scene how long both take to an equal error, their errors against time, and what they
    show after the same time."""
    against = [r for r in rows if "time_to_rmse" in r]
    reached = [r for r in rows if "time to RMSE" in r["case"]]
    plots = dots(
        [dict(r, ratio=r["time_to_rmse"]) for r in against],
        "Mitsuba's time to an equal error over ours",
    )
    head = ["scene, RMSE to be reached", "MC ViSi [s]", "Mitsuba [s]", "ratio"]
    plots += table(
        head,
        [
            [r["case"].replace("time to RMSE ", ""), r["ours"], r["peer"], r["ratio"]]
            for r in reached
        ],
    )
    for scene in dict.fromkeys(scene_of(r) for r in against):
        series = {}
        for row in (r for r in rows if "curve_seconds" in r and scene_of(r) == scene):
            series.setdefault(row["case"].split(", ")[1], []).append(
                (row["curve_seconds"], row["ours"])
            )
        plots += lines(series, f"{scene}: RMSE / mean", "seconds")
        plots += "".join(
            pictures_of_render(r) for r in rows if "picture" in r and scene_of(r) == scene
        )
    return plots


PLOTS = {
    "render": plots_of_render,
    "error": plots_of_error,
    "scale": plots_of_scale,
    "stages": plots_of_stages,
    "build": plots_of_build,
}


def attach_pictures(name, rows, folder):
    """NAME-SCENE.png goes into the page, which refers to no other file."""
    for row in rows:
        path = folder / f"{name}-{scene_of(row).replace(' ', '-')}.png"
        if "picture_samples" in row and path.exists():
            row["picture"] = "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()


def section(name, report, folder):
    rows = report["rows"]
    attach_pictures(name, rows, folder)
    plot = PLOTS.get(name, lambda r: dots(r, "Ratios: right of 1 ours is better"))(rows)
    about = ", ".join(f"{key} {number(report.get(key))}" for key in ABOUT)
    columns = ["case", "unit", "ours", "peer", "ratio", "spread"]
    return (
        f'<h2 id="{name}">{name}</h2>\n<p>{html.escape(about)}</p>\n'
        + table(["summary", ""], report["summary"].items())
        + plot
        + "<details><summary>All rows</summary>"
        + table(columns, [[r[c] for c in columns] for r in rows])
        + "</details>\n"
    )


def begin_page(title):
    """The beginning of a page, up to its body."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"/>'
        f"<title>{title}</title><style>{STYLE}</style></head>\n"
        f"<body><h1>{title}</h1>\n"
    )


def main(folder):
    folder = pathlib.Path(folder)
    reports = {
        p.stem: json.loads(p.read_text())
        for p in sorted(folder.glob("*.json"))
        if p.stem != "summary"
    }
    if not reports:
        sys.exit(f"{folder}: no results of benchmarks")
    (folder / "summary.json").write_text(
        json.dumps({name: r["summary"] for name, r in reports.items()}, indent=1) + "\n"
    )
    page = begin_page("MC ViSi: benchmarks")
    page += "<p>A ratio is above 1 where ours is better; docs/benchmarks.md describes each.</p>\n"
    page += (
        "".join(section(name, report, folder) for name, report in reports.items())
        + "</body></html>\n"
    )
    (folder / "report.html").write_text(page)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: bench/report.py FOLDER")
    main(sys.argv[1])

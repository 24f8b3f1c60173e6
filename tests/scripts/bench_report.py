#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_report.py REPORT FOLDER: the page of three small benchmarks holds their numbers and
picture, is well-formed and refers to no other file."""

import base64
import json
import pathlib
import subprocess
import sys
import xml.etree.ElementTree

report, folder = sys.argv[1], pathlib.Path(sys.argv[2]) / "bench_report"
folder.mkdir(exist_ok=True)


def row(case, unit, ours, peer, ratio, **more):
    return {
        "case": case,
        "unit": unit,
        "ours": ours,
        "peer": peer,
        "ratio": ratio,
        "spread": None,
        **more,
    }


def write(name, rows, summary):
    (folder / f"{name}.json").write_text(
        json.dumps({"device": "a & b", "rows": rows, "summary": summary})
    )


write(
    "traversal",
    [
        row("ball, closest, <Embree>", "Mrays/s", 4.0, 2.0, 2.0),
        row("ball, any, <Embree>", "Mrays/s", 4.0, 8.0, 0.5),
    ],
    {"closest": 2.0},
)
write(
    "scale",
    [
        row(f"bounces {n}", "Mrays/s", 2.0, None, None, bounces=n, nanoseconds=500.0)
        for n in (1, 2, 4)
    ],
    {"slope": None},
)
curve = [
    row(f"lens, {who}, {n} samples", "RMSE/mean", 1 / n, None, None, curve_seconds=n / 9)
    for who in ("MC ViSi", "peer")
    for n in (4, 16)
]
against = row("lens, peer", "Msamples/s", 4.0, 2.0, 2.0, time_to_rmse=3.0)
reached = row("lens, time to RMSE 5 %", "s", 1.0, 3.0, 3.0)
shown = row("lens, at equal time", "RMSE/mean", 0.1, 0.2, 2.0)
for key in ("picture", "peer_picture"):
    shown |= {f"{key}_samples": 16.0, f"{key}_seconds": 0.05}
write("render", [against, *curve, reached, shown], {"left_out": "none"})
(folder / "render-lens.png").write_bytes(b"a picture")
subprocess.run([sys.executable, "-B", report, folder], check=True)

expected = {"render": {"left_out": "none"}, "traversal": {"closest": 2.0}, "scale": {"slope": None}}
summary = json.loads((folder / "summary.json").read_text())
assert summary == expected, f"summary.json is {summary} instead of {expected}"

page = (folder / "report.html").read_text()
root = xml.etree.ElementTree.fromstring(page)  # fails where it is not well-formed
sources = [
    element.attrib[name]
    for element in root.iter()
    for name in ("src", "href")
    if name in element.attrib
]
assert sources == [
    "data:image/png;base64," + base64.b64encode(b"a picture").decode()
], f"the page refers to {sources}"
captions = [c.text for c in root.iter("figcaption")]
assert captions == [
    "MC ViSi: 16 samples, 0.05 s, RMSE 10 %; Mitsuba: 16 samples, 0.05 s, RMSE 20 %; truth"
], captions
svg = "{http://www.w3.org/2000/svg}"
circles = [float(c.attrib["cx"]) for c in root.iter(svg + "circle")]
assert len(circles) == 10, f"{len(circles)} points are drawn instead of 3, 2, 1 and 4"
plot = next(
    p for p in root.iter(svg + "svg") if any("Embree" in t.text for t in p.iter(svg + "title"))
)
ratios = {c.findtext(svg + "title"): float(c.attrib["cx"]) for c in plot.iter(svg + "circle")}
least, most = sorted(ratios.values())
places = [float(t.attrib["x"]) for t in plot.iter(svg + "text") if t.text == "1"]
middle = next(x for x in places if least < x < most)
# 2 and 1/2 lie as far from 1 on a logarithmic axis; places have one decimal.
left, right = (
    middle - ratios["ball, any, <Embree>: 0.5"],
    ratios["ball, closest, <Embree>: 2"] - middle,
)
assert (
    abs(left - right) <= 0.2 and right > 10
), f"ratios 1/2 and 2 are drawn {left} and {right} from 1"
print("the page is as expected")

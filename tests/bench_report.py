#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_report.py REPORT FOLDER: the page of two small benchmarks holds their numbers, is well-formed and refers to no other file."""

import json
import pathlib
import subprocess
import sys
import xml.etree.ElementTree

report, folder = sys.argv[1], pathlib.Path(sys.argv[2]) / "bench_report"
folder.mkdir(exist_ok=True)


def row(case, unit, ours, peer, ratio, **more):
    return {"case": case, "unit": unit, "ours": ours, "peer": peer, "ratio": ratio, "spread": None, **more}


def write(name, rows, summary):
    (folder / f"{name}.json").write_text(json.dumps({"device": "a & b", "rows": rows, "summary": summary}))


write(
    "traversal",
    [row("ball, closest, <Embree>", "Mrays/s", 4.0, 2.0, 2.0), row("ball, any, <Embree>", "Mrays/s", 4.0, 8.0, 0.5)],
    {"closest": 2.0},
)
write("scale", [row(f"bounces {n}", "Mrays/s", 2.0, None, None, bounces=n, nanoseconds=500.0) for n in (1, 2, 4)], {"slope": None})
subprocess.run([sys.executable, "-B", report, folder], check=True)

expected = {"traversal": {"closest": 2.0}, "scale": {"slope": None}}
summary = json.loads((folder / "summary.json").read_text())
assert summary == expected, f"summary.json is {summary} instead of {expected}"

page = (folder / "report.html").read_text()
root = xml.etree.ElementTree.fromstring(page)  # fails where it is not well-formed
for attribute in ("src", "href"):
    assert not any(attribute in element.attrib for element in root.iter()), f"the page refers to another file by {attribute}"
svg = "{http://www.w3.org/2000/svg}"
circles = [float(c.attrib["cx"]) for c in root.iter(svg + "circle")]
assert len(circles) == 5, f"{len(circles)} points are drawn instead of 3 and 2"
ratios = {c.findtext(svg + "title"): float(c.attrib["cx"]) for c in root.iter(svg + "circle") if c.find(svg + "title") is not None}
least, most = sorted(ratios.values())
places = [float(t.attrib["x"]) for t in root.iter(svg + "text") if t.text == "1"]
middle = next(x for x in places if least < x < most)
# 2 and 1/2 lie as far from 1 on a logarithmic axis; places have one decimal.
left, right = middle - ratios["ball, any, <Embree>: 0.5"], ratios["ball, closest, <Embree>: 2"] - middle
assert abs(left - right) <= 0.2 and right > 10, f"ratios 1/2 and 2 are drawn {left} and {right} from 1"
print("the page is as expected")

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gathers what the tests have found beside closed forms: tools/accuracy.py FOLDER reads
FOLDER/rows.jsonl, which tests write where MCVISI_ACCURACY names it (tests/common/truths.h), prints
a table, truth by truth, and writes FOLDER/accuracy.json, FOLDER/report.html with plots and
FOLDER/tables.md, the tables of docs/accuracy.md. Exits with 1 where a truth is missed or no test
has asked for it. Standard library only."""

import html
import json
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "bench"))
import report as page  # noqa: E402

TRUTHS = {
    "T1": (
        "plane-parallel plate",
        "d = t sin a (1 - cos a/sqrt(n^2 - sin^2 a)), direction unchanged",
    ),
    "T2": ("prism", "D = a + asin(sin A sqrt(n^2 - sin^2 a) - cos A sin a) - A"),
    "T3": ("single sphere", "s' = R (1 + sin I'/sin(I - I')), sin I = h/R"),
    "T4": ("ball lens", "h/sin(2 (I - I')) from the centre"),
    "T5": ("aplanatic points", "from R/n to n R for every angle"),
    "T6": ("plano-hyperbolic lens, k = -n^2", "all heights cross at R/(n - 1)"),
    "T7": ("ellipsoid, k = -1/n^2", "all heights cross at n R/(n - 1)"),
    "T8": (
        "conic mirrors",
        "paraboloid R/2; sphere R/(2 cos a) from its centre, sin a = h/R; ellipsoid from R/(1 + "
        "e) to R/(1 - e)",
    ),
    "T9": (
        "thick lens; CODE V's double Gauss",
        "exact rays; 1/f = (n-1)(1/R1 - 1/R2 + (n-1) d/(n R1 R2)), BFD = f (1 - (n-1) d/(n R1))",
    ),
    "T10": (
        "convergence",
        "error ~ mesh^-1 flat, mesh^-2 interpolated, 0 exact; RMSE ~ samples^-1/2 random, at most "
        "samples^-0.58 Sobol'",
    ),
    "T11": ("rainbow", "D = pi + 2 I - 4 I', least 137.9703 degrees for n = 4/3"),
    "T12": ("Fresnel", "R((n-1)/(n+1))^2, Brewster's angle, critical angle, any step and angle"),
    "T13": (
        "diffuse light on an interface, n = 1.5",
        "R = 0.0917779594 from outside, 0.5963457598 from inside",
    ),
    "T14": ("slab, unpolarised at each interface", "T = (1 - R)/(1 + R)"),
    "T15": (
        "furnace",
        "lossless bodies vanish; n^2 L inside; lost energy added back; rough metals and rough "
        "glass send light where walks on microfacets do",
    ),
    "T16": (
        "disk light",
        "E = pi L/2 (1 - (z^2 + p^2 - a^2)/sqrt((z^2 + p^2 + a^2)^2 - 4 a^2 p^2))",
    ),
    "T17": ("sphere light", "E = pi L (r/d)^2 cos a"),
    "T18": ("polygon light", "E = L/2 sum gamma_i n.Gamma_i"),
    "T19": (
        "diffuse furnace, integrating sphere",
        "Le (1 - r^(k+1))/(1 - r); r I/(pi R^2 (1 - r))",
    ),
    "T20": (
        "power",
        "all of it is caught; forward and backward agree; linear to the bit in powers of two; "
        "lights add up",
    ),
    "T21": ("narrow cones", "uniform in solid angle, 1e-7 to pi/2; edge at the half-angle"),
    "T22": (
        "fall-off and magnification",
        "E0 cos^4 a; telecentric E constant, scale independent of depth",
    ),
    "T23": ("depth of field", "c = A f |s2 - s1|/(s2 (s1 - f))"),
    "T24": (
        "light field",
        "4.2.2: macro pixel to place in focus, pixel to place on the lens; 4f system: shift f tan "
        "a",
    ),
    "T25": (
        "MTF of a slanted edge",
        "sinc of the pixel times 2 J1(x)/x of the disc, below Nyquist",
    ),
    "T27": (
        "Gaussian beam",
        "w(z) = w0 sqrt(1 + (z/zR)^2), zR = pi w0^2/(M^2 lambda); I0 = 2 P/(pi w^2); erfc(sqrt2 "
        "x/w)/2 behind an edge",
    ),
    "T28": (
        "Gaussian beam through a lens",
        "w^2 = (A w0)^2 + ((A L + B) M^2 lambda/(pi w0))^2 by the matrix of the lens and the way; "
        "s' - f = f^2 (s - f)/((s - f)^2 + zR^2)",
    ),
    "T29": (
        "speckle",
        "C of a pixel p = sqrt(p^-4 iint (p - |x|)(p - |y|) (2 J1(pi r)/(pi r))^2), p in lambda "
        "N; p(I) = exp(-I)",
    ),
    "T30": (
        "triangulation",
        "P = C + d (n.(P0 - C))/(n.d); centroids of speckle: a spot's C lambda N/(sqrt2 pi), of a "
        "square pupil C lambda N/sqrt(8 pi), a line's by the double integral",
    ),
    "bias": (
        "device against reference",
        "image means within what Welch's test would see, that within 0.1 %",
    ),
    "coverage": (
        "standard errors",
        "|mean - truth| <= t SE as often as Student's t of R - 1 degrees of freedom says, R = 4, "
        "8, 16",
    ),
    "traversal": (
        "rays against triangles",
        "no crack, no double hit at edges; the hit of a loop over all triangles",
    ),
    "T31": (
        "Earth Mover's Distance",
        "deltas, translation, line, mass term, metric, assignments, certificate",
    ),
}

NOT_HERE = {
    "T14": "per polarisation: light is unpolarised at each interface; the formula holds with the mean R",
    "T25": "diffraction: a camera's (`mcvisi camera`), tested in test_edge.c; rays know none",
    "T26": "noise of cameras: test_camera.c and, against the standard's program, test_emva1288_peer.c",
}


def order(name):
    return (int(name[1:]) if name[0] == "T" else math.inf, name)


def read(path):
    """Rows by what they are about, and plots: plot to series to points."""
    rows, plots = {}, {}
    for line in path.read_text().splitlines():
        entry = json.loads(line)
        if "plot" in entry:
            plots.setdefault(entry["plot"], {}).setdefault(entry["series"], []).append(
                (entry["x"], entry["y"])
            )
            continue
        old = rows.setdefault(entry["truth"], {}).get(entry["renderer"])
        if old is None or entry["error"] * old["bound"] > old["error"] * entry["bound"]:
            rows[entry["truth"]][entry["renderer"]] = entry
    return rows, plots


def holds(entry):
    return entry is None or entry["error"] <= entry["bound"]


def as_row(what, found):
    """One row of accuracy.json: errors, each with its bound where they differ."""
    name, _, about = what.partition(" ")
    name = name.rstrip(":")
    device, reference = found.get("device") or found.get("program"), found.get("reference")
    first = device or reference
    return {
        "truth": name,
        "what": about,
        "formula": TRUTHS[name][1] if name in TRUTHS else "",
        "bound": first["bound"],
        "reference_bound": reference["bound"] if reference else None,
        "reference": reference["error"] if reference else None,
        "device": device["error"] if device else None,
        "cases": sum(f["cases"] for f in found.values()),
        "pass": all(holds(f) for f in found.values()),
    }


def short(value):
    return "-" if value is None else f"{value:.2g}"


def bound_of(row):
    """The device's bound, and the reference's where it has one of its own."""
    own = row["reference_bound"]
    return short(row["bound"]) + (
        f" ({short(own)})" if own is not None and own != row["bound"] else ""
    )


def markdown(rows):
    text = ""
    for name in sorted({r["truth"] for r in rows}, key=order):
        title, formula = TRUTHS.get(name, ("", ""))
        text += f"\n### {name}: {title}\n\n`{formula}`\n\n"
        text += "| what | bound | reference | device |\n| --- | --- | --- | --- |\n"
        for r in (r for r in rows if r["truth"] == name):
            what = html.escape(r["what"], quote=False).replace("|", "\\|")
            text += f"| {what} | {bound_of(r)} | {short(r['reference'])} | {short(r['device'])} |\n"
    return text


def histogram(series, title):
    """Counts by whole ULP."""
    left, top, height, step = 60, 30, 160, 14
    parts, most = [page.text(left, 16, title)], max(
        y for points in series.values() for _, y in points
    )
    for tick in range(0, int(math.log10(most)) + 1, 2):
        at = top + height - height * math.log1p(10**tick) / math.log1p(most)
        parts.append(
            f'<path d="M{left} {at:.1f}H{left + step * 33}" stroke="#ddd"/>'
            + page.text(left - 5, at + 4, f"{10**tick:g}", "end")
        )
    for i, points in enumerate(series.values()):
        for x, y in points:
            tall = height * math.log1p(y) / math.log1p(most)
            at = left + step * x + 6 * i
            parts.append(
                f'<rect x="{at:.1f}" y="{top + height - tall:.1f}" width="6"'
                f' height="{tall:.1f}" fill="{page.COLOURS[i]}">'
                f"<title>{y:g} at {x:g} ulp</title></rect>"
            )
    last = max(x for points in series.values() for x, _ in points)
    for x in range(0, int(last) + 1, 4):
        parts.append(
            page.text(
                left + step * x + 6, top + height + 14, f"{x}" if x < last else f"{x}+", "middle"
            )
        )
    parts.append(page.text(left, top + height + 32, "ulp, and how many of them"))
    return page.svg(
        800, top + height + 40, parts + page.legend(series, left + step * 34 + 20, top + 10)
    )


def slope(points):
    points = [(math.log(x), math.log(y)) for x, y in points if x > 0 and y > 0]
    if len(points) < 2:
        return float("nan")
    mean_x, mean_y = (sum(c) / len(points) for c in zip(*points))
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / sum(
        (x - mean_x) ** 2 for x, _ in points
    )


def draw(plots):
    drawn = ""
    for title, series in plots.items():
        if title.startswith("ULP"):
            drawn += histogram(series, title)
        else:
            named = {
                f"{name}: slope {slope(points):.2f}": points for name, points in series.items()
            }
            drawn += page.lines(
                named,
                title,
                title.partition(" over ")[2],
                sum(name.startswith("reference") for name in named),
            )
    return drawn


def main(folder):
    folder = pathlib.Path(folder)
    found, plots = read(folder / "rows.jsonl")
    rows = sorted(
        (as_row(what, f) for what, f in found.items()), key=lambda r: (order(r["truth"]), r["what"])
    )
    missing = [name for name in TRUTHS if not any(r["truth"] == name for r in rows)]
    print(f"{'':5} {'':62} {'bound':>9} {'reference':>10} {'device':>9}")
    for name in sorted({r["truth"] for r in rows}, key=order):
        print(
            f"{name:5} {TRUTHS[name][0] if name in TRUTHS else ''}: "
            f"{TRUTHS[name][1] if name in TRUTHS else ''}"
        )
        for r in (r for r in rows if r["truth"] == name):
            found = f"{bound_of(r):>9} {short(r['reference']):>10} {short(r['device']):>9}"
            print(f"{'':5} {r['what'][:62]:62} {found} {'' if r['pass'] else 'MISSED'}")
    for name, why in NOT_HERE.items():
        print(f"{name:5} {why}")
    for name in missing:
        print(f"{name:5} {TRUTHS[name][0]}: no test has asked for it")
    failed = [r for r in rows if not r["pass"]]
    print(
        f"{len(rows)} rows of {len(rows) and len({r['truth'] for r in rows})} truths, "
        f"{len(failed)} missed"
    )

    (folder / "accuracy.json").write_text(
        json.dumps(
            {"rows": rows, "missing": missing, "not_here": NOT_HERE, "plots": plots}, indent=1
        )
        + "\n"
    )
    columns = [
        "truth",
        "what",
        "formula",
        "bound",
        "reference_bound",
        "reference",
        "device",
        "cases",
        "pass",
    ]
    document = page.begin_page("MC ViSi: accuracy")
    document += "<p>Errors of the device and of the reference renderer against closed forms, each "
    document += "below its bound.</p>\n"
    document += draw(plots) + page.table(columns, [[r[c] for c in columns] for r in rows])
    document += (
        "<h2>Not here</h2><ul>"
        + "".join(f"<li>{n}: {html.escape(why)}</li>" for n, why in NOT_HERE.items())
        + "</ul></body></html>\n"
    )
    (folder / "report.html").write_text(document)
    (folder / "tables.md").write_text(markdown(rows).lstrip("\n"))
    return 1 if failed or missing else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: tools/accuracy.py FOLDER")
    sys.exit(main(sys.argv[1]))

# SPDX-License-Identifier: Apache-2.0
"""Figures and table of docs/inverse-patterns.md: inverse-patterns.py SCENES FOLDER

The report's lens before a telecentric camera and a light field display, and as it is before a light
field camera: at which light does the dent show?"""

import json
import pathlib
import struct
import sys
import zlib

import matplotlib
import mcvisi as mv
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

PLACES, DIRECTIONS, SEEDS = (40, 30), 16, 4
DENT, BACKGROUND = np.s_[10:20, 15:25], np.s_[4:26, 28:38]
LIGHT = (30, 100, 300, 1e3, 1e4, 1e5)


def white_png(width, height):
    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    rows = (b"\0" + b"\xff" * width) * height
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = (b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)


def schlieren_rig(scene, path):
    """The scene with a telecentric camera that accepts 0.76 mrad, and a display behind the lens."""
    data = scene.read_bytes()
    size = struct.unpack("<I", data[12:16])[0]
    rig = json.loads(data[20 : 20 + size])
    rig["extensions"]["MCVISI_sensors"]["sensors"][0] = {
        "name": "camera", "type": "telecentric", "magnification": 0.1,
        "workingDistance": "300mm", "fNumber": 66, "resolution": list(PLACES),
        "pixelSize": "18um", "radiometry": "radiance",
    }  # fmt: skip
    rig["extensions"]["MCVISI_emitters"]["emitters"][0] = {
        "name": "display", "type": "lightField", "size": ["7.2mm", "5.4mm"],
        "spatialResolution": list(PLACES), "angularResolution": [DIRECTIONS] * 2,
        "angularRange": 0.016, "radiance": 1, "image": "white",
    }  # fmt: skip
    rig["images"] = [{"name": "white", "uri": "white.png"}]
    text = json.dumps(rig).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
    path.write_bytes(head + struct.pack("<I4s", len(text), b"JSON") + text + rest)
    return mv.load(path)


def contrast_to_noise(values):
    """(mean of the dent's region - mean of the background)/deviation of the background."""
    background = values[BACKGROUND]
    return (np.mean(values[DENT]) - np.mean(background)) / np.std(background, ddof=1)


def over_light(image, mean, picture):
    """Contrast to noise of `picture` of an image with so many electrons a place in the mean."""
    rows = []
    for light in LIGHT:
        found = []
        for seed in range(SEEDS):
            noise = np.random.default_rng(seed)
            found.append(
                contrast_to_noise(picture(noise.poisson(np.maximum(image, 0) / mean * light)))
            )
        rows.append((np.mean(found), np.std(found, ddof=1) / np.sqrt(SEEDS)))
    return rows


def gradient(values):
    image = mv.Image(values.astype(np.float32), attributes={"mcvisi:angularResolution": [9, 9]})
    return np.asarray(image.emd_gradient())


def light_field(scene):
    rig = mv.load(scene)
    rig["sensors/camera/regionOfInterest"] = [60, 45, *PLACES]
    return np.asarray(rig.render(spp=1024, seed=3, progress=False)).astype(float)


def matrix(scenes, folder, defect, seed):
    rig = schlieren_rig(scenes / ("report-%s.glb" % defect), folder / ("%s.glb" % defect))
    return rig.transport(spp=4096, seed=seed, progress=False)


def compare(scenes, defect, patterns, part, check):
    """Prints the table of a defect; returns its curves and pictures."""
    table, shown = {}, {}
    for name, pattern in patterns.items():
        good, bad = (
            np.asarray(each.relight({"display": pattern})).astype(float) for each in (check, part)
        )
        bright = good.mean() if name != "dark field" else bad[DENT].mean()
        print("%s: deviation of the flawless part %.2g" % (name, good.std() / bright))
        if name != "dark field":  # whose background has no light, and no deviation
            table[name] = over_light(bad, bright, lambda values: values.astype(float))
        shown[name] = bad / bright
    field = light_field(scenes / ("report-%s.glb" % defect))
    places = field.reshape(PLACES[1], 9, PLACES[0], 9).sum(axis=(1, 3))
    table["Earth Mover's gradient"] = over_light(field, np.median(places), gradient)
    shown["Earth Mover's gradient"] = gradient(field)
    print("%s: | electrons a place | %s |" % (defect, " | ".join(table)))
    for row, light in enumerate(LIGHT):
        cells = ["%.1f ± %.1f" % table[name][row] for name in table]
        print("| %g | %s |" % (light, " | ".join(cells)))
    return table, shown


def draw(table, shown, path):
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.2))
    for axis, (name, image) in zip(axes.flat, shown.items()):
        axis.imshow(image, cmap="gray" if "gradient" not in name else "viridis")
        axis.set_title(name)
        axis.set_axis_off()
    curves = axes[1, 1]
    for name, rows in table.items():
        values, errors = zip(*rows)
        curves.errorbar(LIGHT, np.abs(values), errors, marker="o", ms=3, label=name)
    curves.set(xscale="log", yscale="log", xlabel="electrons a place", ylabel="contrast to noise")
    curves.axhline(3, color="black", lw=0.5)
    curves.legend(fontsize=7)
    axes[1, 2].set_axis_off()
    figure.tight_layout()
    figure.savefig(path, dpi=80)


def main():
    scenes, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    (folder / "white.png").write_bytes(white_png(*(DIRECTIONS * side for side in PLACES)))
    clean, check = (matrix(scenes, folder, "clean", seed) for seed in (1, 7))
    ways = {
        "replay": {"method": "replay"},
        "least squares": {"method": "least-squares"},
        "dark field": {"field": "dark"},
    }
    patterns = {name: np.asarray(clean.inverse_pattern(**way)) for name, way in ways.items()}
    for defect in "dent", "bubble":
        part = matrix(scenes, folder, defect, 1)
        table, shown = compare(scenes, defect, patterns, part, check)
        if defect == "dent":
            draw(table, shown, folder / "inverse-patterns.png")


main()

# SPDX-License-Identifier: Apache-2.0
"""Set-ups of inspection, the wrong one and the right one in a scene, for ./run gallery: which
sensor, which light. Each says in its note what to change. Cameras see 280 x 210 pixels."""

import math
import random

from basics import box, diffuse, square
from gltf import Scene, facing

PIXELS = [280, 210]


def turned(profile, count=64):
    """The surface that a profile (r, y) makes about the y axis, from below to above, with normals;
    creases where a point stands twice."""
    positions, normals, triangles = [], [], []
    for r, y in profile:
        positions += [
            (r * math.cos(2 * math.pi * i / count), y, r * math.sin(2 * math.pi * i / count))
            for i in range(count)
        ]
    for k in range(len(profile)):
        slopes = [
            (profile[i + 1][1] - profile[i][1], profile[i][0] - profile[i + 1][0])
            for i in (k - 1, k)
            if 0 <= i < len(profile) - 1 and profile[i] != profile[i + 1]
        ]
        x, y = (sum(s[i] / math.hypot(*s) for s in slopes) for i in (0, 1))
        length = math.hypot(x, y)
        normals += [
            (
                x / length * math.cos(2 * math.pi * i / count),
                y / length,
                x / length * math.sin(2 * math.pi * i / count),
            )
            for i in range(count)
        ]
    for k in range(len(profile) - 1):
        for i in range(count if profile[k] != profile[k + 1] else 0):
            a, b = k * count + i, k * count + (i + 1) % count
            triangles += [(a, a + count, b + count), (a, b + count, b)]
    return positions, triangles, normals


def hexagon(width, low, high):
    """A prism about the y axis, `width` across its flats, flat faces."""
    positions, triangles = [], []
    corners = [
        (
            width / math.sqrt(3) * math.cos(math.pi / 3 * i + 0.3),
            width / math.sqrt(3) * math.sin(math.pi / 3 * i + 0.3),
        )
        for i in range(6)
    ]
    for i in range(6):
        (x0, z0), (x1, z1) = corners[i], corners[(i + 1) % 6]
        base = len(positions)
        positions += [(x0, low, z0), (x0, high, z0), (x1, high, z1), (x1, low, z1)]
        triangles += [(base, base + 1, base + 2), (base, base + 2, base + 3)]
    for y in (low, high):
        base = len(positions)
        positions += [(x, y, z) for x, z in corners]
        for i in range(1, 5):
            triangles.append(
                (base, base + i, base + i + 1) if y == low else (base, base + i + 1, base + i)
            )
    return positions, triangles


def bolts():
    """Two bolts M6 x 16, one 20 mm nearer: a lens sees the nearer one larger, a telecentric lens
    both alike."""
    scene = Scene(
        "Two equal bolts, one 20 mm nearer, before a backlight: sensors entocentric and "
        "telecentric."
    )
    steel = diffuse(scene, "steel", 0.35)
    shank = [(0, -0.010), (0.0023, -0.010), (0.0023, -0.010), (0.003, -0.0093), (0.003, -0.0093)]
    for i in range(9):
        y = -0.0093 + 0.001 * i
        shank += [(0.003, y + 0.0001), (0.0024, y + 0.0005), (0.003, y + 0.0009)]
    shank += [(0.003, 0), (0.003, 0), (0.003, 0.006)]
    shank_mesh = scene.mesh("shank", steel, *turned(shank))
    head_mesh = scene.mesh("head", steel, *hexagon(0.010, 0.006, 0.010))
    for name, x, z in (("near", -0.009, 0.010), ("far", 0.009, -0.010)):
        scene.node(name + " shank", mesh=shank_mesh, translation=[x, 0, z])
        scene.node(name + " head", mesh=head_mesh, translation=[x, 0, z])
    scene.node(
        "backlight",
        translation=[0, 0, -0.05],
        rotation=facing((0, 0, 1)),
        emitter={"type": "area", "size": ["80mm", "60mm"], "radiance": 1},
    )
    scene.node(
        "front",
        translation=[-0.05, 0.06, 0.10],
        rotation=facing((0.05, -0.06, -0.10)),
        emitter={"type": "bar", "length": "100mm", "width": "30mm", "radiance": 12},
    )
    # Both see 39.2 x 29.4 mm at the origin, which is in focus.
    film = {"resolution": PIXELS, "pixelSize": "28um"}
    at = [0, 0, 0.150]
    scene.node(
        "entocentric",
        translation=at,
        sensor=dict(
            {"type": "thinLens", "focalLength": "25mm", "focusDistance": "150mm", "fNumber": 16},
            **film,
        ),
    )
    scene.node(
        "telecentric",
        translation=at,
        sensor=dict(
            {
                "type": "telecentric",
                "magnification": 0.2,
                "workingDistance": "150mm",
                "fNumber": 16,
            },
            **film,
        ),
    )
    return scene.gltf()


def telecentric(scene, name="camera"):
    """From above (+z): m = 1/2 at 150 mm, f/8, 14.3 x 10.7 mm of field, 51 µm a pixel."""
    return scene.node(
        name,
        translation=[0, 0, 0.150],
        sensor={
            "type": "telecentric",
            "magnification": 0.5,
            "workingDistance": "150mm",
            "fNumber": 8,
            "resolution": PIXELS,
            "pixelSize": "25.5um",
        },
    )


def stains(width, height):
    """Grey of between 70 and 230 (sRGB) that changes smoothly, from random numbers at the knots of
    three grids."""
    source = random.Random(7)
    grids = [[[source.random() for _ in range(n + 2)] for _ in range(n + 2)] for n in (4, 9, 20)]

    def smooth(grid, u, v):
        n = len(grid) - 2
        i, j = int(u * n), int(v * n)
        s, t = (x * x * (3 - 2 * x) for x in (u * n - i, v * n - j))
        return (1 - t) * ((1 - s) * grid[j][i] + s * grid[j][i + 1]) + t * (
            (1 - s) * grid[j + 1][i] + s * grid[j + 1][i + 1]
        )

    rows = []
    for y in range(height):
        row = []
        for x in range(width):
            value = sum(
                w * smooth(g, (x + 0.5) / width, (y + 0.5) / height)
                for w, g in zip((0.45, 0.35, 0.2), grids)
            )
            row.append((70 + int(160 * value),) * 3)
        rows.append(row)
    return rows


def scratch():
    """A ground steel plate with stains and a scratch 100 µm wide and 30 µm deep."""
    scene = Scene(
        "A scratch in stained steel. Bright field: emitters/ring/radiance=0; dark field: "
        "emitters/coaxial/radiance=0."
    )
    steel = scene.metal("steel", 0.25, scene.image("stains", stains(96, 72)))
    x0, x1, y0, y1, count = -0.010, 0.010, -0.0075, 0.0075, 60
    positions, texcoords, triangles = [], [], []

    def quad(*corners):
        base = len(positions)
        positions.extend(corners)
        texcoords.extend(((x - x0) / (x1 - x0), (y1 - y) / (y1 - y0)) for x, y, _ in corners)
        triangles.extend(((base, base + 1, base + 2), (base, base + 2, base + 3)))

    def path(x):
        return 0.25 * x + 25 * x * x - 0.0008, 0.5e-4 * math.sqrt(max(0, 1 - (x / 0.006) ** 2))

    for i in range(count):
        a, b = (x0 + (x1 - x0) * (i + k) / count for k in (0, 1))
        (ya, wa), (yb, wb) = path(a), path(b)
        quad((a, y0, 0), (b, y0, 0), (b, yb - wb, 0), (a, ya - wa, 0))
        quad((a, ya + wa, 0), (b, yb + wb, 0), (b, y1, 0), (a, y1, 0))
        if wa or wb:
            quad((a, ya - wa, 0), (b, yb - wb, 0), (b, yb, -0.6 * wb), (a, ya, -0.6 * wa))
            quad((a, ya, -0.6 * wa), (b, yb, -0.6 * wb), (b, yb + wb, 0), (a, ya + wa, 0))
    scene.node("plate", mesh=scene.mesh("plate", steel, positions, triangles, texcoords=texcoords))
    scene.node(
        "coaxial",
        translation=[0, 0, 0.06],
        emitter={"type": "coaxial", "size": ["34mm", "34mm"], "halfAngle": "20deg", "radiance": 10},
    )
    scene.node(
        "ring",
        translation=[0, 0, 0.012],
        emitter={
            "type": "ring",
            "innerDiameter": "50mm",
            "outerDiameter": "64mm",
            "tilt": "80deg",
            "radiance": 10,
        },
    )
    telecentric(scene)
    return scene.gltf()


LETTERS = (
    "X...X..XX",
    "X...X.X.X",
    "X...X...X",
    "XXXXX...X",
    "X...X...X",
    "X...X...X",
    "X...X...X",
)  # H1, a cell is a millimetre


def engraved(light):
    """Ground steel, not quite even, into which H1 is milled: strokes 1 mm wide and 0.2 mm deep,
    their floor rougher and darker."""
    scene = Scene("Engraved steel under a " + light + " light.")
    steel, floor = scene.metal("steel", 0.2, colour=0.6), scene.metal("floor", 0.6, colour=0.3)
    source = random.Random(3)
    columns, rows, cell, depth = 19, 15, 0.001, 0.0002
    across, down = (columns - len(LETTERS[0])) // 2, (rows - len(LETTERS)) // 2
    tilts = {
        (i, j): (source.gauss(0, 0.04), source.gauss(0, 0.04))
        for j in range(rows + 1)
        for i in range(columns + 1)
    }
    top, bottom = ([], [], []), ([], [], [])

    def milled(i, j):
        line, column = j - down, i - across
        return (
            0 <= line < len(LETTERS)
            and 0 <= column < len(LETTERS[0])
            and LETTERS[line][column] == "X"
        )

    def add(mesh, corners, normals):
        positions, all_normals, triangles = mesh
        base = len(positions)
        positions.extend(corners)
        all_normals.extend(normals)
        triangles.extend(((base, base + 1, base + 2), (base, base + 2, base + 3)))

    for j in range(rows):
        for i in range(columns):
            x, y = (i - columns / 2) * cell, (rows / 2 - j) * cell
            knots = ((i, j + 1), (i + 1, j + 1), (i + 1, j), (i, j))
            z = -depth if milled(i, j) else 0
            corners = [(x, y - cell, z), (x + cell, y - cell, z), (x + cell, y, z), (x, y, z)]
            if not milled(i, j):
                add(
                    top,
                    corners,
                    [
                        (
                            u / math.sqrt(1 + u * u + v * v),
                            v / math.sqrt(1 + u * u + v * v),
                            1 / math.sqrt(1 + u * u + v * v),
                        )
                        for u, v in (tilts[k] for k in knots)
                    ],
                )
                continue
            add(bottom, corners, [(0, 0, 1)] * 4)
            for k, (di, dj) in enumerate(((0, 1), (1, 0), (0, -1), (-1, 0))):
                if milled(i + di, j + dj):
                    continue
                (ax, ay, _), (bx, by, _) = corners[k], corners[(k + 1) % 4]
                add(
                    bottom,
                    [(ax, ay, 0), (bx, by, 0), (bx, by, -depth), (ax, ay, -depth)],
                    [(-di, dj, 0)] * 4,
                )
    for name, material, mesh in (("top", steel, top), ("milled", floor, bottom)):
        scene.node(name, mesh=scene.mesh(name, material, mesh[0], mesh[2], mesh[1]))
    height, emitter = {
        "ring": (0.08, {"type": "ring", "innerDiameter": "24mm", "outerDiameter": "50mm"}),
        "dome": (0, {"type": "dome", "diameter": "240mm", "holeDiameter": "20mm"}),
        "coaxial": (0.06, {"type": "coaxial", "size": ["34mm", "34mm"], "halfAngle": "20deg"}),
    }[light]
    scene.node(light, translation=[0, 0, height], emitter=dict(emitter, radiance=1))
    telecentric(scene)
    return scene.gltf()


def structured_light(note, pattern, readout):
    """A step of 4 mm under a pattern; the camera looks along -z, the projector from the side by its
    azimuth."""
    scene = Scene(note)
    grey = diffuse(scene, "part", 0.6)
    plate = scene.mesh("plate", grey, *square(0.05))
    scene.node("plate", mesh=plate)
    scene.node(
        "step", mesh=scene.mesh("step", grey, *box((-0.009, -0.008, 0), (0.009, 0.0, 0.004)))
    )
    scene.node(
        "projector",
        pose={"target": [0, 0, 0], "distance": "200mm", "azimuth": "-30deg"},
        emitter={
            "type": "telecentricProjector",
            "size": ["40mm", "40mm"],
            "halfAngle": "0.2deg",
            "power": 0.02,
            "pattern": pattern,
            "index": 0,
        },
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.150],
        sensor=dict(
            {
                "type": "telecentric",
                "magnification": 0.2,
                "workingDistance": "150mm",
                "fNumber": 8,
                "resolution": PIXELS,
                "pixelSize": "20um",
            },
            **readout,
        ),
    )
    return scene.gltf()


def phase_shift():
    return structured_light(
        "Phase-shifted stripes on a step: emitters/projector/index=0 to 3; "
        "nodes/projector/azimuth says from how far aside.",
        {"type": "phaseShift", "steps": 4, "periods": 6, "resolution": [480, 480]},
        {},
    )


def gray_code():
    """The camera's axis meets the film 20 pixels above its middle; around the step 180 x 120 pixels
    are read out, two by two."""
    return structured_light(
        "Gray code on a step: emitters/projector/index=0 to 5 are the bits of the column, the "
        "coarsest first. Of the camera's film a "
        "region is read out, binned, off its principal point.",
        {"type": "grayCode", "resolution": [64, 64]},
        {"principalPoint": [140, 85], "regionOfInterest": [50, 50, 180, 120], "binning": [2, 2]},
    )


def laser_head():
    """A laser line runs over a plate of white plastic and a wedge of ground steel, whose top slopes by
    15 degrees towards the camera. Laser and camera are on the same side, 15 and 45 degrees aside:
    they look away from the wedge's glare. The film is tilted, so that the plane of the light is in
    focus."""
    scene = Scene(
        "A laser triangulation head over plastic and a wedge of steel that slopes towards the camera: "
        "it looks away from the wedge's glare, which nodes/laser/elevation 90deg and "
        "nodes/camera/elevation 60deg show. `mcvisi scan` measures it."
    )
    scene.wavelengths = "660nm"
    plastic = diffuse(scene, "plastic", 0.8)
    steel = scene.material("steel", {"type": "conductor", "metal": "iron", "roughness": 0.4})
    scene.node(
        "plate", mesh=scene.mesh("plate", plastic, *box((-0.03, -0.005, -0.01), (0.03, 0, 0.01)))
    )
    wedge, triangles = box((0.001, 0, -0.004), (0.03, 0.003, 0.004))
    slope = math.tan(math.radians(15))
    wedge = [(x, y - slope * z if y > 0 else y, z) for x, y, z in wedge]
    scene.node("wedge", mesh=scene.mesh("wedge", steel, wedge, triangles))
    scene.node(
        "camera",
        sensor={
            "name": "camera",
            "type": "laserTriangulation",
            "focalLength": "25mm",
            "focusDistance": "250mm",
            "fNumber": 8,
            "tilt": "10.893deg",
            "tiltDirection": "180deg",
            "resolution": PIXELS,
            "pixelSize": "5um",
            "radiometry": "irradiance",
            "laser": "laser",
            "profiles": 4,
            "feed": "0.2mm",
            "exposeTo": 0.8,
        },
        pose={"target": [0, 0.0015, 0], "distance": "250mm", "elevation": "45deg"},
    )
    scene.node(
        "laser",
        emitter={
            "name": "laser",
            "type": "laser",
            "wavelength": "660nm",
            "power": 0.02,
            "lineThickness": "150um",
            "widthMeasure": "1/e2",
            "workingDistance": "200mm",
            "fanAngle": "20deg",
        },
        pose={"target": [0, 0.0015, 0], "distance": "200mm", "elevation": "75deg"},
    )
    return scene.gltf()


def files():
    return {
        "laser-head.gltf": laser_head(),
        "bolts.gltf": bolts(),
        "scratch.gltf": scratch(),
        "structured-light.gltf": phase_shift(),
        "gray-code.gltf": gray_code(),
        **{"engraved-%s.gltf" % light: engraved(light) for light in ("ring", "dome", "coaxial")},
    }

# SPDX-License-Identifier: Apache-2.0
"""The scenes of bench_render that are made of meshes, as users render them: CAD, boards, vials.

mesh_scenes.py [--seed N] FOLDER [NAME...] writes each as NAME.gltf with what it needs; case(FOLDER,
NAME, N) gives the same to Mitsuba. Seed 0 has the scenes that docs/benchmarks.md describes; each
other seed has other shapes, counts, lights and views of the same kinds. Lengths are in metres, +y
is up. All geometry is generated here.
"""

import argparse
import json
import pathlib
import struct
import zlib

import numpy as np

TURN = 2 * np.pi
ALUMINIUM = {"n": 1.1, "k": 6.7}
CORNER = 4 * np.pi  # tessellation of what is round is never aligned with the axes


class Variant:
    """The numbers of a scene: those of the description with seed 0, others about them otherwise."""

    def __init__(self, name, seed):
        self.seed = seed
        self.random = np.random.default_rng([seed, zlib.crc32(name.encode())])

    def near(self, value, spread=0.25):
        return value * self.random.uniform(1 - spread, 1 + spread) if self.seed else value

    def count(self, value, spread=0.25):
        return round(self.near(value, spread))

    def below(self, value, least=0.7):
        return value * self.random.uniform(least, 1) if self.seed else value

    def generator(self, number):
        """Of what a description leaves to chance."""
        return np.random.default_rng([self.seed, number] if self.seed else number)


# --- meshes: positions, triangles, and normals and texture coordinates, or None ---


def mesh(positions, triangles, normals=None, uv=None):
    return {
        "positions": np.asarray(positions, "f4"),
        "triangles": np.asarray(triangles, "u4").reshape(-1, 3),
        "normals": None if normals is None else np.asarray(normals, "f4"),
        "uv": None if uv is None else np.asarray(uv, "f4"),
    }


def joined(parts):
    """One mesh of several without normals and texture coordinates."""
    starts = np.cumsum([0] + [len(p["positions"]) for p in parts])
    return mesh(
        np.concatenate([p["positions"] for p in parts]),
        np.concatenate([p["triangles"] + s for p, s in zip(parts, starts)]),
    )


def grid(columns, rows):
    """Two triangles for each cell of (columns x rows) points, counter-clockwise where rows point to
    -z and columns to +x, seen from +y."""
    at = np.arange(columns * rows).reshape(rows, columns)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def sheet(width, depth, height=None, columns=2, rows=2):
    """In the xz plane, its front up; `height`: of points (columns x rows), or flat."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    y = np.zeros_like(u) if height is None else height(u, v)
    positions = np.stack([(u - 0.5) * width, y, (0.5 - v) * depth], axis=-1).reshape(-1, 3)
    return mesh(positions, grid(columns, rows), uv=np.stack([u, 1 - v], axis=-1).reshape(-1, 2))


def revolved(profile, segments, at=(0, 0, 0)):
    """About +y: points (radius, height), from bottom to top where the outside is the front. What is
    on the axis is one triangle a segment."""
    profile = np.asarray(profile, float)
    angle = np.arange(segments) * TURN / segments + CORNER / segments
    r, y = profile[:, :1], profile[:, 1:]
    points = np.stack([r * np.cos(angle), y + 0 * angle, -r * np.sin(angle)], axis=-1)
    ring = np.arange(len(profile) * segments).reshape(-1, segments)
    a, b = ring[:-1], np.roll(ring, -1, axis=1)[:-1]
    c, d = np.roll(ring, -1, axis=1)[1:], ring[1:]
    lower = np.stack([a, b, c], axis=-1)[profile[:-1, 0] > 0]
    upper = np.stack([a, c, d], axis=-1)[profile[1:, 0] > 0]
    triangles = np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return mesh(points.reshape(-1, 3) + np.asarray(at), triangles)


def box(size, at, turn=0.0):
    corner = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    c, s = np.cos(turn), np.sin(turn)
    place = (corner * size) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + at
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh(place, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def lens(radius, curvature, segments, rings):
    """Both sides alike, with the normals of their spheres; a cylinder as its edge."""
    sag = lambda r: np.sqrt(curvature**2 - r**2) - np.sqrt(curvature**2 - radius**2)
    r = np.linspace(0, radius, rings)
    parts, normals = [], []
    edge = 0.002
    for side in (-1, 1):
        profile = np.stack([r, side * (edge / 2 + sag(r))], axis=-1)
        part = revolved(profile if side < 0 else profile[::-1], segments)
        centre = np.array([0, side * (edge / 2 - np.sqrt(curvature**2 - radius**2)), 0])
        normal = part["positions"] - centre
        parts.append(part)
        normals.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
    rim = revolved([(radius, -edge / 2), (radius, edge / 2)], segments)
    normal = rim["positions"] * [1, 0, 1]
    parts.append(rim)
    normals.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
    whole = joined(parts)
    return {**whole, "normals": np.concatenate(normals).astype("f4")}


def ball(radius, at, segments):
    angle = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    profile = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    profile[0, 0] = profile[-1, 0] = 0
    return revolved(profile, segments, at)


def turned_part(bosses, segments, fillet, random):
    """A plate with bosses as a CAD system tessellates them: fillets of fine rings, caps as fans."""
    parts = [box((0.12, 0.01, 0.12), (0, -0.005, 0), 0.1)]
    side = int(np.ceil(np.sqrt(bosses)))
    for i in range(bosses):
        x, z = 0.1 * ((i % side + 0.5) / side - 0.5), 0.1 * ((i // side + 0.5) / side - 0.5)
        r, h = 0.1 / side * random.uniform(0.2, 0.32), random.uniform(0.004, 0.02)
        f = 0.2 * r
        low, high = np.linspace(np.pi / 2, 0, fillet), np.linspace(0, np.pi / 2, fillet)
        foot = [(r + f - f * np.cos(a), f - f * np.sin(a)) for a in low]
        head = [(r - f + f * np.cos(a), h - f + f * np.sin(a)) for a in high]
        profile = foot + head + [(0.4 * r, h), (0.4 * r, 0.3 * h), (0, 0.3 * h)]
        parts.append(revolved(profile, segments, (x, 0, z)))
    return joined(parts)


def bolt(length, segments, turns):
    """On its head, with rings in place of a thread."""
    r, pitch = 0.18 * length, 0.6 * length / turns
    thread = [(q * r, 0.4 * length + (i + h) * pitch) for i in range(turns) for q, h in ((1, 0), (0.85, 0.5))]
    head = [(0, 0), (1.7 * r, 0), (1.8 * r, 0.02 * length), (1.8 * r, 0.2 * length), (r, 0.22 * length)]
    return revolved(head + thread + [(0.8 * r, length), (0, length)], segments)


# --- pictures ---


def png(picture):
    """8 bits, RGB."""
    rows = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(picture))
    chunk = lambda name, data: (
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    )
    head = struct.pack(">IIBBBBB", picture.shape[1], picture.shape[0], 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def board_picture(v, size=2048):
    """Solder resist with traces and pads; no two places alike."""
    random = v.generator(3)
    picture = np.full((size, size, 3), (20, 90, 40), "u1")
    for _ in range(v.count(900)):
        x, y, length = random.integers(0, size, 3)
        width = int(random.integers(4, 12))
        colour = (190, 160, 80) if random.random() < 0.3 else (35, 120, 60)
        if random.random() < 0.5:
            picture[y : y + width, x : x + length // 4] = colour
        else:
            picture[y : y + length // 4, x : x + width] = colour
    return picture


def checker_picture(v, pixels=16):
    cells = 2 * v.count(16)
    at = np.indices((cells * pixels, cells * pixels)) // pixels
    return np.where((at.sum(0) % 2)[..., None], (225, 220, 210), (40, 45, 50)).astype("u1")


def exr(picture):
    """32 bits, B, G and R, scanlines without compression."""
    height, width = picture.shape[:2]

    def attribute(name, kind, value):
        return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value

    channels = b"".join(
        name + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", channels + b"\0")
    head += attribute("compression", "compression", b"\0") + attribute(
        "dataWindow", "box2i", window
    )
    head += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = 12 * width
    places = len(head) + 8 * height + (8 + size) * np.arange(height)
    rows = [
        struct.pack("<ii", y, size) + picture[y, :, ::-1].T.astype("<f4").tobytes()
        for y in range(height)
    ]
    return head + places.astype("<u8").tobytes() + b"".join(rows)


def sun_picture(variant, width=512):
    """By longitude and latitude: a sky, ground, and a sun of some 1.4 degrees."""
    east, high, bright = variant.near(0.62), variant.near(0.14), variant.near(1)
    v, u = np.mgrid[0 : width // 2, 0:width]
    height = 1 - (v + 0.5) / (width / 4)
    sky = np.where(height[..., None] > 0, [0.4, 0.6, 1.0], [0.1, 0.09, 0.08]) * (1 + 0 * u[..., None])
    sun = (u - east * width) ** 2 + (v - high * width) ** 2 < 1.5**2
    return np.where(sun[..., None], bright * np.array([9000, 8000, 6500]), sky).astype("f4")


# --- scenes ---


def camera(origin, target, half_width, lens=0.0, focus=0.0):
    """half_width: of the field, over its distance."""
    return {
        "origin": origin,
        "target": target,
        "half_width": half_width,
        "lens": lens,
        "focus": focus,
    }


def lamp(origin, target, size, radiance):
    return {"origin": origin, "target": target, "size": size, "radiance": radiance}


def ring(count, radius, height, size, radiance, target=(0, 0, 0)):
    angles = np.arange(count) * TURN / count
    return [
        lamp((radius * np.cos(a), height, radius * np.sin(a)), target, size, radiance)
        for a in angles
    ]


def diffuse(reflectance):
    return {"type": "diffuse", "reflectance": reflectance}


def metal(alpha_x, alpha_y=None):
    """alpha_x: along u."""
    return {"type": "conductor", "alpha": (alpha_x, alpha_y or alpha_x)}


def glass(inside, outside=1.0, priority=0, absorption=0.0):
    return {
        "type": "glass",
        "inside": inside,
        "outside": outside,
        "priority": priority,
        "absorption": absorption,
    }


def body(shape, material, **more):
    """only: "ours" or "theirs", where both describe what is nested in their own ways. instances:
    pairs of a rotation (3 x 3) and a place; without them the body is where its mesh is."""
    return {"mesh": shape, "material": material, **more}


WHITE = diffuse([0.8, 0.75, 0.7])


def lens_scene(v):
    wall = sheet(0.6, 0.6)
    turned = wall["positions"][:, [0, 2, 1]] * [1, -1, 1] + [0, 0, -0.15]
    body_lens = lens(v.near(0.025), v.near(0.05), v.count(256), v.count(48))
    for key in ("positions", "normals"):
        body_lens[key] = (body_lens[key][:, [0, 2, 1]] * [1, -1, 1]).astype("f4")
    return {
        "camera": camera((v.near(0.03) if v.seed else 0, 0, 0.3), (0, 0, 0), v.near(0.15), lens=v.near(0.008), focus=v.near(0.42, 0.1)),
        "lamps": [lamp((v.near(0.15), 0.25, 0.15), (0, 0, -0.1), (v.near(0.06), 0.06), 20)],
        "bodies": [body(mesh(turned, wall["triangles"], uv=wall["uv"]), {**diffuse(1.0), "picture": "checker"}), body(body_lens, glass(1.5))],
    }


def board_scene(v):
    random = v.generator(5)
    parts = []
    for _ in range(v.count(200)):
        size = random.uniform(0.001, 0.009, 3) * (1, 0.4, 1)
        x, z = random.uniform(-0.048, 0.048, 2)
        parts.append(box(size, (x, size[1] / 2, z), random.choice([0, np.pi / 2, 0.01])))
    return {
        "camera": camera((0, 0.25, v.near(0.06)), (0, 0, 0), 0.21, lens=v.near(0.006), focus=0.25),
        "lamps": ring(v.count(24), v.near(0.12), v.near(0.15), (0.01, 0.01), 60),
        "bodies": [
            body(sheet(0.1, 0.1), {**diffuse(1.0), "picture": "board"}),
            body(joined(parts), diffuse([0.15, 0.15, 0.17])),
            body(sheet(0.5, 0.5, lambda u, w: 0 * u - 0.002), WHITE),
        ],
    }


def cad_scene(v, fine):
    segments, fillet = (v.count(360), v.count(16)) if fine else (v.count(48), v.count(4))
    material = metal(v.below(0.2)) if fine else diffuse([0.5, 0.5, 0.5])
    part = turned_part(v.count(19), segments, fillet, v.generator(7))
    return {
        "camera": camera((v.near(0.05), 0.25, v.near(0.12)), (0, 0, 0), 0.24),
        "lamps": ring(v.count(24), v.near(0.15), v.near(0.18), (0.02, 0.02), 30),
        "bodies": [body(part, material), body(sheet(0.6, 0.6, lambda u, w: 0 * u - 0.0101), WHITE)],
    }


def sun_scene(v):
    return {**cad_scene(v, True), "lamps": [], "sky": "sun"}


def tray_scene(v):
    """One bolt in many places, in a tray under four bars."""
    random, side = v.generator(17), v.count(12)
    pitch, places = 0.16 / side, []
    for i in range(side * side):
        turn, tilt = random.uniform(0, TURN), np.pi / 2 + random.uniform(-0.1, 0.1)
        about_x = [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
        about_y = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
        at = [(i % side - side / 2 + 0.5) * pitch, 0.0045, (i // side - side / 2 + 0.5) * pitch]
        places.append((np.array(about_y) @ np.array(about_x), at))
    bars = [((0.2, 0.2, 0), (0.02, 0.3)), ((-0.2, 0.2, 0), (0.02, 0.3)), ((0, 0.2, 0.2), (0.3, 0.02)), ((0, 0.2, -0.2), (0.3, 0.02))]
    bolts = bolt(v.near(0.01, 0.1), v.count(48), v.count(12))
    floor = sheet(0.5, 0.5, lambda u, w: 0 * u - 0.001)
    return {
        "camera": camera((0, 0.3, v.near(0.1)), (0, 0, 0), 0.28),
        "lamps": [lamp(at, (0, 0, 0), size, v.near(8)) for at, size in bars],
        "bodies": [body(bolts, metal(v.below(0.15)), instances=places), body(floor, WHITE)],
    }


def vial_scene(v):
    inner, floor, top, level, segments = 0.0105, 0.0015, 0.04, v.near(0.026), v.count(256)
    outer = inner + v.near(0.0015, 0.4)
    shell = revolved([(0, 0), (outer, 0), (outer, top), (inner, top), (inner, floor), (0, floor)], segments)
    overlap = 0.5 * (outer - inner)
    liquid = revolved([(0, floor - overlap), (inner + overlap, floor - overlap), (inner + overlap, level), (0, level)], segments)
    bubble = ball(v.near(0.0015), (v.near(0.003), 0.014, 0.002), v.count(32) * 2)
    tint = (v.near(8.0), v.near(30.0), 60.0)
    wall = lambda material, profile: body(revolved(profile, segments), material, only="theirs")
    return {
        "camera": camera((0, 0.02, 0.25), (0, 0.02, 0), 0.1),
        "lamps": [lamp((0, 0.02, -0.1), (0, 0.02, 0), (0.12, 0.12), 1), lamp((v.near(0.1), 0.2, 0.15), (0, 0, 0), (0.02, 0.02), 20)],
        "bodies": [
            body(sheet(0.3, 0.3, lambda u, w: 0 * u - 0.0005), WHITE),
            body(shell, glass(1.5, priority=2), only="ours"),
            body(liquid, glass(1.33, priority=1, absorption=tint), only="ours"),
            body(bubble, glass(1.0, priority=3), only="ours"),
            wall(glass(1.5), [(0, 0), (outer, 0), (outer, top), (inner, top), (inner, level)]),
            wall(
                {**glass(1.5, 1.33), "outer_absorption": tint},
                [(inner, level), (inner, floor), (0, floor)],
            ),
            wall(glass(1.33, 1.0, absorption=tint), [(inner, level), (0, level)]),
            body(bubble, {**glass(1.0, 1.33), "outer_absorption": tint}, only="theirs"),
        ],
    }


def displaced_scene(v):
    random, points = v.generator(11), v.count(1001, 0.15)
    waves = [(random.uniform(2, 60, 2), random.uniform(0, TURN, 2)) for _ in range(40)]

    def height(u, w):
        total = 0 * u
        for (a, b), (p, q) in waves:
            total += np.sin(TURN * a * u + p) * np.sin(TURN * b * w + q) * 0.012 / (a + b) ** 0.9
        return total

    return {
        "camera": camera((0, v.near(0.12), 0.2), (0, 0, 0), 0.25),
        "lamps": [lamp((0.15, v.near(0.15), v.near(0.05)), (0, 0, 0), (0.05, 0.05), 20)],
        "bodies": [body(sheet(0.2, 0.2, height, points, points), WHITE)],
        "depth": 8,
    }


def lamps_scene(v):
    random, side = v.generator(13), v.count(8)
    lamps = []
    for i in range(side * side):
        x, z = (0.9 * ((2 * k + 1) / side - 1) for k in (i % side, i // side))
        lamps.append(lamp((x, 0.99, z), (x, 0, z + 1e-3), (0.03, 0.03), 30 * random.uniform(0.2, 1)))
    room = box((2, 2, 2), (0, 0, 0))
    room["triangles"] = room["triangles"][:, ::-1].copy()
    parts = [box(random.uniform(0.1, 0.4, 3), (x, -0.85, z), random.uniform(0, 1)) for x, z in random.uniform(-0.8, 0.8, (v.count(12), 2))]
    return {
        "camera": camera((0, 0.1, 0.98), (0, -0.3, 0), 0.7),
        "lamps": lamps,
        "bodies": [body(room, WHITE), body(joined(parts), diffuse([0.4, 0.5, 0.6]))],
        "depth": 8,
    }


def plate_scene(v):
    radii = [v.near(radius) for radius in (6, 12, 20)]

    def height(u, w):
        x, y = 60 * (u - 0.5), 60 * (w - 0.5)
        depth = 0 * u
        for radius in radii:
            depth -= np.exp(-((np.hypot(x, y) - radius) ** 2) / 0.3)
        depth -= np.where(
            (np.abs(x) < 25) & (np.abs(y - 24) < 3), np.exp(-((np.mod(x, 4) - 2) ** 2) / 0.2), 0
        )
        return 0.0004 * depth

    return {
        "camera": camera((0, 0.3, 0.001), (0, 0, 0), 0.12),
        "lamps": ring(v.count(24), v.near(0.08, 0.1), v.near(0.02, 0.1), (0.012, 0.006), 60),
        "bodies": [body(sheet(0.06, 0.06, height, 301, 301), metal(v.below(0.3), v.below(0.08)))],
    }


SCENES = {
    "mesh lens": lens_scene,
    "mesh board": board_scene,
    "mesh part": lambda v: cad_scene(v, False),
    "mesh metal part": lambda v: cad_scene(v, True),
    "mesh part in the sun": sun_scene,
    "mesh vial": vial_scene,
    "mesh displaced": displaced_scene,
    "mesh lamps": lamps_scene,
    "mesh plate": plate_scene,
    "mesh tray": tray_scene,
}
PICTURES = {"board": board_picture, "checker": checker_picture}


def scene_of(name, seed):
    return SCENES[name](Variant(name, seed))


def file_name(name):
    return name.replace(" ", "-")


# --- for ours ---


def pose(origin, target):
    """Columns of a node's matrix that looks from origin to target along its -z."""
    origin, target = np.asarray(origin, float), np.asarray(target, float)
    z = (origin - target) / np.linalg.norm(origin - target)
    up = np.array([0, 0, -1.0]) if abs(z[1]) > 0.99 else np.array([0, 1.0, 0])
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    return x, y, z, origin


def matrix(origin, target):
    return [float(v) for column, w in zip(pose(origin, target), (0, 0, 0, 1)) for v in (*column, w)]


def our_material(material):
    kind = material["type"]
    if kind == "diffuse":
        made = {
            "extensions": {
                "MCVISI_materials": {"type": "diffuse", "reflectance": material["reflectance"]}
            }
        }
    elif kind == "conductor":
        x, y = material["alpha"]
        # glTF's KHR_materials_anisotropy: alpha along the tangent is mixed between roughness² and
        # 1.
        roughness = y**0.5
        anisotropy = ((x - y) / (1 - y)) ** 0.5
        made = {
            "extensions": {
                "MCVISI_materials": {
                    "type": "conductor",
                    **ALUMINIUM,
                    "roughness": roughness,
                    "anisotropy": anisotropy,
                }
            }
        }
    else:
        inside = {"type": "dielectric", "ior": material["inside"], "priority": material["priority"]}
        made = {
            "extensions": {"MCVISI_materials": {**inside, "absorption": material["absorption"]}}
        }
    return made


def write(folder, name, seed):
    folder = pathlib.Path(folder)
    scene, stem = scene_of(name, seed), file_name(name)
    data, views, accessors, meshes, materials, nodes, images = b"", [], [], [], [], [], []

    def accessor(array, kind, target):
        nonlocal data
        views.append(
            {"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes, "target": target}
        )
        entry = {
            "bufferView": len(views) - 1,
            "componentType": 5125 if array.dtype == np.uint32 else 5126,
            "count": len(array) if kind != "SCALAR" else array.size,
            "type": kind,
        }
        if kind == "VEC3":
            entry |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        accessors.append(entry)
        data += np.ascontiguousarray(array).tobytes()
        return len(accessors) - 1

    for number, part in enumerate(scene["bodies"]):
        if part.get("only") == "theirs":
            continue
        shape, material = part["mesh"], our_material(part["material"])
        attributes = {"POSITION": accessor(shape["positions"], "VEC3", 34962)}
        if shape["normals"] is not None:
            attributes["NORMAL"] = accessor(shape["normals"], "VEC3", 34962)
        if shape["uv"] is not None:
            attributes["TEXCOORD_0"] = accessor(shape["uv"], "VEC2", 34962)
        if "picture" in part["material"]:
            images.append({"uri": f"{part['material']['picture']}.png"})
            material["pbrMetallicRoughness"] = {
                "baseColorTexture": {"index": len(images) - 1},
                "metallicFactor": 0,
            }
        material["name"] = f"material {number}"
        indices = accessor(shape["triangles"], "SCALAR", 34963)
        meshes.append(
            {
                "primitives": [
                    {"attributes": attributes, "indices": indices, "material": len(materials)}
                ]
            }
        )
        materials.append(material)
        for i, (turn, at) in enumerate(part.get("instances", [(np.eye(3), (0, 0, 0))])):
            place = np.eye(4)
            place[:3, :3], place[:3, 3] = turn, at
            nodes.append({"name": f"body {number} {i}", "mesh": len(meshes) - 1, "matrix": place.T.ravel().tolist()})
    emitters = [{"name": f"lamp {i}", "type": "area", "size": list(e["size"]), "radiance": e["radiance"]} for i, e in enumerate(scene["lamps"])]
    for i, e in enumerate(scene["lamps"]):
        nodes.append(
            {
                "name": f"lamp {i}",
                "matrix": matrix(e["origin"], e["target"]),
                "extensions": {"MCVISI_emitters": {"emitter": i}},
            }
        )
    if "sky" in scene:
        emitters.append(
            {"name": "sky", "type": "environment", "image": {"uri": f"{scene['sky']}.exr"}}
        )
        nodes.append(
            {"name": "sky", "extensions": {"MCVISI_emitters": {"emitter": len(emitters) - 1}}}
        )
    seen = scene["camera"]
    sensor = {
        "name": "camera",
        "type": "pinhole",
        "imageDistance": 0.1,
        "resolution": [256, 256],
        "pixelSize": 0.2 * seen["half_width"] / 256,
    }
    if seen["lens"] > 0:
        focal = 0.02
        image_distance = 1 / (1 / focal - 1 / seen["focus"])
        sensor |= {
            "type": "thinLens",
            "focalLength": focal,
            "focusDistance": seen["focus"],
            "lensDiameter": 2 * seen["lens"],
            "pixelSize": 2 * seen["half_width"] * image_distance / 256,
        }
        del sensor["imageDistance"]
    nodes.append(
        {
            "name": "camera",
            "matrix": matrix(seen["origin"], seen["target"]),
            "extensions": {"MCVISI_sensors": {"sensor": 0}},
        }
    )
    (folder / f"{stem}.bin").write_bytes(data)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "extensionsUsed": ["MCVISI_emitters", "MCVISI_materials", "MCVISI_sensors"],
        "extensions": {
            "MCVISI_sensors": {"sensors": [sensor]},
            "MCVISI_emitters": {"emitters": emitters},
        },
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data), "uri": f"{stem}.bin"}],
    }
    if images:
        document |= {"images": images, "textures": [{"source": i} for i in range(len(images))]}
    (folder / f"{stem}.gltf").write_text(json.dumps(document))


# --- for Mitsuba ---


# Mitsuba starts rays (1 + |p|) 1500 roundings off surfaces, some 0.1 mm in metres: it gets cm.
SCALE = 100


def placed(part):
    """The mesh of a body; of instances all in one mesh, with which Mitsuba is ten times as fast."""
    if "instances" not in part:
        return part["mesh"]
    points, triangles = part["mesh"]["positions"], part["mesh"]["triangles"]
    return joined([mesh(points @ turn.T + at, triangles) for turn, at in part["instances"]])


def write_ply(path, shape):
    columns = [SCALE * shape["positions"]] + [
        shape[k] for k in ("normals", "uv") if shape[k] is not None
    ]
    names = (
        ["x", "y", "z"]
        + (["nx", "ny", "nz"] if shape["normals"] is not None else [])
        + (["u", "v"] if shape["uv"] is not None else [])
    )
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(shape['positions'])}"]
    head += [f"property float {n}" for n in names]
    head += [
        f"element face {len(shape['triangles'])}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    faces = np.zeros(len(shape["triangles"]), dtype=[("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, shape["triangles"]
    path.write_bytes("\n".join(head).encode() + b"\n" + np.concatenate(columns, axis=1).astype("<f4").tobytes() + faces.tobytes())


def their_material(material, folder, rgb):
    kind = material["type"]
    if kind == "diffuse":
        reflectance = rgb(material["reflectance"])
        if "picture" in material:
            reflectance = {"type": "bitmap", "filename": str(folder / f"{material['picture']}.png")}
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
    if kind == "conductor":
        x, y = material["alpha"]
        eta = {"eta": ALUMINIUM["n"], "k": ALUMINIUM["k"], "specular_reflectance": rgb(1.0)}
        return {
            "type": "twosided",
            "bsdf": {
                "type": "roughconductor",
                "distribution": "ggx",
                "alpha_u": x,
                "alpha_v": y,
                **eta,
            },
        }
    return {"type": "dielectric", "int_ior": material["inside"], "ext_ior": material["outside"]}


def case(folder, name, seed=0):
    """(scene, sensor, depth), of what has been written to the folder: dictionaries to which the
    integrator, and film and sampler, are to be added."""
    import mitsuba as mi

    folder, scene, parts = pathlib.Path(folder), scene_of(name, seed), {}
    T = mi.ScalarTransform4f
    rgb = lambda value: {"type": "rgb", "value": value}

    def medium(sigma):
        most = max(sigma)
        tint = rgb([s / most for s in sigma])
        return {"type": "homogeneous", "albedo": 0.0, "sigma_t": tint, "scale": most / SCALE}

    def place(origin, target):
        """Looks along +z, with +x to the left."""
        x, y, z, o = pose(origin, target)
        return T(np.vstack([np.column_stack([-x, y, -z, SCALE * o]), [0, 0, 0, 1]]))

    for number, part in enumerate(scene["bodies"]):
        if part.get("only") == "ours":
            continue
        path = folder / f"{file_name(name)}-{number}.ply"
        write_ply(path, placed(part))
        shape = {"type": "ply", "filename": str(path), "face_normals": part["mesh"]["normals"] is None}
        shape["bsdf"] = their_material(part["material"], folder, rgb)
        if np.any(part["material"].get("absorption", 0.0)):
            shape["interior"] = medium(part["material"]["absorption"])
        if "outer_absorption" in part["material"]:
            shape["exterior"] = medium(part["material"]["outer_absorption"])
        parts[f"body {number}"] = shape
    for i, e in enumerate(scene["lamps"]):
        size = [SCALE * e["size"][0] / 2, SCALE * e["size"][1] / 2, 1]
        black = {"type": "diffuse", "reflectance": rgb(0.0)}
        emitter = {"type": "area", "radiance": rgb(e["radiance"])}
        to_world = place(e["origin"], e["target"]) @ T().scale(size)
        parts[f"lamp {i}"] = {
            "type": "rectangle",
            "to_world": to_world,
            "bsdf": black,
            "emitter": emitter,
        }
    if "sky" in scene:
        to_world = T().rotate([0, 1, 0], 180)
        parts["sky"] = {
            "type": "envmap",
            "filename": str(folder / f"{scene['sky']}.exr"),
            "to_world": to_world,
        }
    seen = scene["camera"]
    fov = float(np.degrees(2 * np.arctan(seen["half_width"])))
    sensor = {"type": "perspective", "fov": fov, "to_world": place(seen["origin"], seen["target"])}
    if seen["lens"] > 0:
        lens = {"aperture_radius": SCALE * seen["lens"], "focus_distance": SCALE * seen["focus"]}
        sensor |= {"type": "thinlens", **lens}
    return parts, sensor, scene.get("depth", 32)


def main(folder, names, seed):
    folder.mkdir(parents=True, exist_ok=True)
    for picture, make in PICTURES.items():
        (folder / f"{picture}.png").write_bytes(png(make(Variant(picture, seed))))
    (folder / "sun.exr").write_bytes(exr(sun_picture(Variant("sun", seed))))
    for name in names or SCENES:
        write(folder, name, seed)


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("folder", type=pathlib.Path)
    options.add_argument("names", nargs="*", metavar="NAME", help=", ".join(SCENES))
    options.add_argument("--seed", type=int, default=0, help="variant of the scenes; 0: as described")
    told = options.parse_args()
    main(told.folder, told.names, told.seed)

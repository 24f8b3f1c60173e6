# SPDX-License-Identifier: Apache-2.0
"""
Parts as they come out of CAD programs and Blender, for the tests of rigs: parts.py FOLDER writes

    bracket.stl   an angle of sheet metal with two bores [mm], binary
    cover.stl     a shell of clear plastic on a flange, as over an instrument [mm], ASCII
    weak.stl      a plano-convex lens of 1292 mm radius, 50 mm wide [mm], binary
    vial.glb      a vial of glass with water in it and a cap. Materials and nodes have the names
                  that Blender exports. The glass has no thickness, so that it is read as a thin
                  sheet. The exporter's extras contain U+0000.
"""

import json
import math
import os
import struct
import sys

# --- solids as lists of triangles


def quad(a, b, c, d):
    return [(a, b, c), (a, c, d)]


def box(lower, upper):
    corner = [[(upper if i >> k & 1 else lower)[k] for k in range(3)] for i in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return [t for f in faces for t in quad(*[tuple(corner[i]) for i in f])]


def plate_with_bore(lower, upper, centre, radius, sides, segments=96):
    """A plate [lower, upper] with a bore along z, and those of its sides (-y, +x, +y, -x) that are
    chosen."""

    def rim(i):
        angle = 2 * math.pi * (i % segments) / segments
        return centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)

    def edge(i):
        """Where a ray from the bore meets the border; every eighth of the turn its corners."""
        angle = 2 * math.pi * (i % segments) / segments - math.pi / 4
        side, along = divmod(i % segments, segments // 4)
        along /= segments // 4
        corners = [
            (upper[0], upper[1]),
            (lower[0], upper[1]),
            (lower[0], lower[1]),
            (upper[0], lower[1]),
        ]
        a, b = corners[side - 1 if side else 3], corners[side]
        return a[0] + (b[0] - a[0]) * along, a[1] + (b[1] - a[1]) * along

    def turned(i):
        return rim(i - segments // 8)

    triangles = []
    for i in range(segments):
        for z, up in ((upper[2], True), (lower[2], False)):
            ring = [p + (z,) for p in (turned(i), edge(i), edge(i + 1), turned(i + 1))]
            triangles += quad(*(ring if up else ring[::-1]))
        (x, y), (u, v) = turned(i), turned(i + 1)
        triangles += quad((x, y, lower[2]), (x, y, upper[2]), (u, v, upper[2]), (u, v, lower[2]))
        (x, y), (u, v) = edge(i), edge(i + 1)
        if sides[(i // (segments // 4) + 1) % 4]:
            triangles += quad(
                (x, y, lower[2]), (u, v, lower[2]), (u, v, upper[2]), (x, y, upper[2])
            )
    return triangles


def lathe(profile, segments=128):
    """The profile (r, z), turned about z; the solid is on its left. A pair of points is a band."""

    def at(r, z, i):
        angle = 2 * math.pi * (i % segments) / segments
        return (r * math.cos(angle), r * math.sin(angle), z) if r > 0 else (0.0, 0.0, z)

    triangles = []
    for (r, z), (s, w) in zip(profile, profile[1:]):
        for i in range(segments):
            a, b, c, d = at(r, z, i), at(r, z, i + 1), at(s, w, i + 1), at(s, w, i)
            triangles += [t for t in quad(a, b, c, d) if len(set(t)) == 3]
    return triangles


def bracket():
    """60 x 40 mm with two bores of 10 and 8 mm, 30 mm apart, 4 mm thick; its wall is 25 mm high."""
    left = plate_with_bore((0, 0, 0), (30, 40, 4), (15, 20), 5, (True, False, True, True))
    right = plate_with_bore((30, 0, 0), (60, 40, 4), (45, 20), 4, (True, True, True, False))
    return left + right + box((0, 36, 4), (60, 40, 25))


def cover():
    """
    A spherical shell of 30 and 28 mm radius, 40 mm wide, on a flange of 50 mm, 2 mm thick. They
    meet at 42 degrees, more than the crease angle of 30 degrees; facets of the shell meet at 1.3
    degrees.
    """
    outer, inner, half = 30.0, 28.0, 20.0
    base = math.sqrt(outer**2 - half**2)
    outside = [math.asin(half / outer) * k / 32 for k in range(33)]
    rim = math.acos((base - 2) / inner)  # where the inner sphere meets the flange's lower side
    inside = [rim * k / 32 for k in range(33)]
    profile = [(inner * math.sin(a), inner * math.cos(a) - base) for a in inside[:-1]] + [
        (inner * math.sin(rim), -2.0)
    ]
    profile += [(25.0, -2.0), (25.0, 0.0), (half, 0.0)]
    profile += [(outer * math.sin(a), outer * math.cos(a) - base) for a in outside[-2::-1]]
    return lathe(profile)


def weak_lens():
    """Its focal length is 2.5 m at an index of 1.5168. Facets meet at 0.05 degrees."""
    radius, half, count = 1292.0, 25.0, 24
    heights = [half * k / count for k in range(count + 1)]
    edge = radius - math.sqrt(radius**2 - half**2)
    profile = [(0.0, -2.0), (half, -2.0)]
    profile += [(h, math.sqrt(radius**2 - h**2) - radius + edge) for h in heights[::-1]]
    return lathe(profile)


# --- files


def write_stl(path, triangles):
    with open(path, "wb") as file:
        file.write(b"exported".ljust(80, b"\0") + struct.pack("<I", len(triangles)))
        for t in triangles:
            file.write(struct.pack("<12f", 0, 0, 0, *[x for p in t for x in p]) + b"\0\0")


def write_ascii_stl(path, triangles):
    with open(path, "w", encoding="ascii") as file:
        file.write("solid cover\n")
        for t in triangles:
            file.write(
                "facet normal 0 0 0\nouter loop\n"
                + "".join("vertex %.6e %.6e %.6e\n" % p for p in t)
                + "endloop\nendfacet\n"
            )
        file.write("endsolid cover\n")


def smooth(profile_of, triangles):
    """Positions, normals and indices; vertices are shared within a band, as exporters do for smooth
    shading with sharp edges."""
    positions, normals, indices, known = [], [], [], {}
    for band, normal_at in zip(triangles, profile_of):
        for t in band:
            for p in t:
                n = normal_at(p)
                key = (p, tuple(round(x, 6) for x in n))
                if key not in known:
                    known[key] = len(positions)
                    positions.append(p)
                    normals.append(n)
                indices.append(known[key])
    return positions, normals, indices


def turned(profile):
    """A body of revolution in metres, y upwards, bands with the exact normals of their cones."""
    bands, of = [], []
    for a, b in zip(profile, profile[1:]):
        if a == b:
            continue
        bands.append(
            [tuple((p[0] * 1e-3, p[2] * 1e-3, -p[1] * 1e-3) for p in t) for t in lathe([a, b])]
        )
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        outward, up = (b[1] - a[1]) / length, -(b[0] - a[0]) / length

        def normal(p, outward=outward, up=up):
            r = math.hypot(p[0], p[2])
            return (
                (outward * p[0] / r, up, outward * p[2] / r)
                if r > 0
                else (0.0, math.copysign(1.0, up), 0.0)
            )

        of.append(normal)
    return smooth(of, bands)


def vial():
    """22 mm wide, 45 mm high, walls of 1.2 mm, filled to 25 mm, under a cap."""
    glass = turned([(0, 0), (11, 0), (11, 45), (9.8, 45), (9.8, 25), (9.8, 1.5), (0, 1.5)])
    water = turned([(0, 1.5), (9.8, 1.5), (9.8, 25), (0, 25)])
    cap = turned([(0, 45), (11.8, 45), (11.8, 53), (0, 53)])
    blob, views, accessors, meshes, nodes = b"", [], [], [], []

    def add(data, component, kind, count, **more):
        nonlocal blob
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        accessors.append(
            dict(
                {
                    "bufferView": len(views) - 1,
                    "componentType": component,
                    "count": count,
                    "type": kind,
                },
                **more
            )
        )
        blob += data + b"\0" * (-len(data) % 4)
        return len(accessors) - 1

    for name, mesh, material in (("Vial.001", glass, 0), ("Liquid", water, 1), ("Cap", cap, 2)):
        positions, normals, indices = mesh
        flat = [x for p in positions for x in p]
        attributes = {
            "POSITION": add(
                struct.pack("<%df" % len(flat), *flat),
                5126,
                "VEC3",
                len(positions),
                min=[min(flat[k::3]) for k in range(3)],
                max=[max(flat[k::3]) for k in range(3)],
            ),
            "NORMAL": add(
                struct.pack("<%df" % len(flat), *[x for n in normals for x in n]),
                5126,
                "VEC3",
                len(normals),
            ),
        }
        meshes.append(
            {
                "name": name,
                "primitives": [
                    {
                        "attributes": attributes,
                        "material": material,
                        "indices": add(
                            struct.pack("<%dI" % len(indices), *indices),
                            5125,
                            "SCALAR",
                            len(indices),
                        ),
                    }
                ],
            }
        )
        nodes.append({"name": name, "mesh": len(meshes) - 1, "extras": {"sourceId": "a\0b"}})
    nodes.append({"name": "Assembly", "children": [0, 1, 2]})
    clear = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.45},
    }
    materials = [
        {
            "name": "Glass.001",
            "extensions": clear,
            "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0},
        },
        {
            "name": "Water",
            "extensions": clear,
            "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0},
        },
        {
            "name": "Plastic (white)",
            "pbrMetallicRoughness": {"roughnessFactor": 0.5, "metallicFactor": 0},
        },
    ]
    document = {
        "asset": {"version": "2.0", "generator": "Khronos glTF Blender I/O v4.2.70"},
        "scene": 0,
        "scenes": [{"nodes": [3]}],
        "extensionsUsed": sorted(clear),
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return (
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob))
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(blob), b"BIN\0")
        + blob
    )


def main():
    folder = sys.argv[1]
    write_stl(os.path.join(folder, "bracket.stl"), bracket())
    write_stl(os.path.join(folder, "weak.stl"), weak_lens())
    write_ascii_stl(os.path.join(folder, "cover.stl"), cover())
    with open(os.path.join(folder, "vial.glb"), "wb") as file:
        file.write(vial())


main()

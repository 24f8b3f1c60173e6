# SPDX-License-Identifier: Apache-2.0
"""The experiment of the report's section 5: parallel light through a double-convex lens into a
light field camera, for a flawless lens, one with an air bubble inside and one with a shallow dent.

The lens is a mesh with the surface's exact normals at its vertices. Between them the renderer
interpolates normal and position, so facets of edge h err by

    position   sag <= h²/(6 R) below the sphere, at a facet's centroid (h²/6 times the curvature
               in general)
    normal     on a sphere N = (P - C)/R is linear in P, so the interpolated normal is the exact one
               of the point that lies sag·tanθ further along the surface: its angle errs by
               sag·tanθ/R. On the dent z''' is not 0: <= h²/6 |z'''|
    ray        turned by (n - 1) times that angle, displaced by (n - 1)·sag·tanθ

Lens: h = 14 mm/48 = 0.29 mm, R = 310 mm, tanθ <= 0.1: sag 46 nm, ray displaced by 2.4 nm and turned
by 7.7e-9 rad, 2.3 nm after the 0.3 m to the camera. Its rim is a 288-gon: 0.83 µm inside the
circle. Dent: h = 40 µm, z'' <= A/σ² = 10/m, z''' <= 1.38 A/σ³ = 2.8e4/m²: sag 2.7 nm, normal 7.4e-6
rad, ray 1.2 µm in the pupil. A macro pixel sees 180 µm of the lens and a sub-pixel 2.2 mm of the
pupil, so no facet can show. Bubble: h <= 20 µm, R = 0.5 mm: sag 0.14 µm."""

import math

from gltf import Scene

RADIUS = 0.310
THICKNESS = 0.006
SEMI_DIAMETER = 0.014
IOR = 1.5168
CENTRE = -0.301022  # front vertex at -0.298022
RIM = 288  # vertices on the rim
RINGS = 48  # RIM = 6 RINGS: near-equilateral facets up to the rim
MOUNT_RADIUS = 0.030
BUBBLE_RADIUS = 0.0005
DENT_DEPTH, DENT_SIGMA = 2.5e-6, 0.0005


def sphere_sag(r):
    """Depth below the vertex at distance r from the axis (without cancellation), and its
    derivative."""
    root = math.sqrt(RADIUS * RADIUS - r * r)
    return r * r / (RADIUS + root), r / root


def dented_sag(r):
    """The same for the dented surface."""
    depth, slope = sphere_sag(r)
    gauss = DENT_DEPTH * math.exp(-0.5 * (r / DENT_SIGMA) ** 2)
    return depth + gauss, slope - gauss * r / DENT_SIGMA**2


def uniform_radii():
    return [SEMI_DIAMETER * k / RINGS for k in range(RINGS + 1)]


def dent_radii():
    """48 rings 40 µm apart reach 3.8 σ; from there the steps grow by at most 15 % to at most 0.3
    mm."""
    radii = [40e-6 * k for k in range(RINGS + 1)]
    step = 40e-6
    while radii[-1] < SEMI_DIAMETER:
        step = min(1.15 * step, 0.3e-3)
        radii.append(radii[-1] + step)
    inside = radii[: RINGS + 1]
    scale = (SEMI_DIAMETER - inside[-1]) / (radii[-1] - inside[-1])  # the last ring lies on the rim
    return (
        inside
        + [inside[-1] + (r - inside[-1]) * scale for r in radii[RINGS + 1 : -1]]
        + [SEMI_DIAMETER]
    )


def circle(radius, count):
    return [
        (radius * math.cos(2 * math.pi * i / count), radius * math.sin(2 * math.pi * i / count))
        for i in range(count)
    ]


def ring_size(k):
    return min(6 * k, RIM) if k else 1


def disk(radii):
    """Points and triangles (counter-clockwise) of a disk of rings: ring k has 6 k points, at most
    RIM."""
    points, triangles, start = [], [], 0
    for k, r in enumerate(radii):
        size = ring_size(k)
        points += circle(r, size)
        if k:
            inner, outer, inner_size = start - ring_size(k - 1), start, ring_size(k - 1)
            steps = size // 6
            inner_steps = 0 if k == 1 else inner_size // 6
            for sector in range(6):
                for j in range(steps):
                    a = outer + sector * steps + j
                    b = outer + (sector * steps + j + 1) % size
                    # Between growing rings the facets alternate; between equal rings each step is a
                    # quadrilateral.
                    c = inner + (sector * inner_steps + min(j, inner_steps)) % inner_size
                    triangles.append((c, a, b))
                    if j < inner_steps:
                        d = inner + (sector * inner_steps + j + 1) % inner_size
                        triangles.append((c, b, d))
        start += size
    return points, triangles


def lens(scene, material, front_sag, front_radii):
    """The closed lens about its centre: front (towards +z), back and cylinder edge share the rims'
    positions exactly."""
    positions, normals, triangles = [], [], []
    for side, sag, radii in ((1, front_sag, front_radii), (-1, sphere_sag, uniform_radii())):
        points, facets = disk(radii)
        base = len(positions)
        for x, y in points:
            r = math.hypot(x, y)
            depth, slope = sag(r)
            length = math.sqrt(1 + slope * slope)
            positions.append((x, y, side * (THICKNESS / 2 - depth)))
            normals.append(
                (slope / length * x / r, slope / length * y / r, side / length)
                if r
                else (0, 0, side)
            )
        triangles += [
            (base + a, base + b, base + c) if side > 0 else (base + a, base + c, base + b)
            for a, b, c in facets
        ]
    # The edge has a ring of vertices in the middle, where the mount touches it.
    depth, _ = sphere_sag(SEMI_DIAMETER)
    rim = circle(SEMI_DIAMETER, RIM)
    base = len(positions)
    for z in (THICKNESS / 2 - depth, 0, depth - THICKNESS / 2):
        positions += [(x, y, z) for x, y in rim]
        normals += [(x / SEMI_DIAMETER, y / SEMI_DIAMETER, 0) for x, y in rim]
    for ring in (base, base + RIM):
        triangles += strip(ring, ring + RIM)
    return scene.mesh("lens", material, positions, triangles, normals)


def strip(upper, lower):
    """Triangles between two rings of RIM vertices, front side outwards (lower) or upwards (a ring
    inside another)."""
    triangles = []
    for i in range(RIM):
        j = (i + 1) % RIM
        triangles += [(upper + i, lower + i, lower + j), (upper + i, lower + j, upper + j)]
    return triangles


def mount(scene, material):
    """The absorbing annulus in the lens's middle plane; its inner vertices are those of the lens's
    edge."""
    positions = [
        (x, y, 0) for radius in (SEMI_DIAMETER, MOUNT_RADIUS) for x, y in circle(radius, RIM)
    ]
    return scene.mesh("mount", material, positions, strip(0, RIM), [(0, 0, 1)] * len(positions))


def ball(radius, subdivisions):
    """Positions, triangles and normals of a sphere: an icosahedron, each edge halved `subdivisions`
    times."""
    g = (1 + math.sqrt(5)) / 2
    points = [
        (-1, g, 0),
        (1, g, 0),
        (-1, -g, 0),
        (1, -g, 0),
        (0, -1, g),
        (0, 1, g),
        (0, -1, -g),
        (0, 1, -g),
        (g, 0, -1),
        (g, 0, 1),
        (-g, 0, -1),
        (-g, 0, 1),
    ]
    triangles = [
        (0, 11, 5),
        (0, 5, 1),
        (0, 1, 7),
        (0, 7, 10),
        (0, 10, 11),
        (1, 5, 9),
        (5, 11, 4),
        (11, 10, 2),
        (10, 7, 6),
        (7, 1, 8),
        (3, 9, 4),
        (3, 4, 2),
        (3, 2, 6),
        (3, 6, 8),
        (3, 8, 9),
        (4, 9, 5),
        (2, 4, 11),
        (6, 2, 10),
        (8, 6, 7),
        (9, 8, 1),
    ]

    def unit(p):
        length = math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
        return p[0] / length, p[1] / length, p[2] / length

    points = [unit(p) for p in points]
    for _ in range(subdivisions):
        halves, finer = {}, []

        def half(a, b):
            key = (a, b) if a < b else (b, a)
            if key not in halves:
                halves[key] = len(points)
                p, q = points[key[0]], points[key[1]]
                points.append(unit((p[0] + q[0], p[1] + q[1], p[2] + q[2])))
            return halves[key]

        for a, b, c in triangles:
            ab, bc, ca = half(a, b), half(b, c), half(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return [(radius * x, radius * y, radius * z) for x, y, z in points], triangles, points


def glass(scene, name, ior, thickness, priority=0):
    """A dielectric, with the core extensions that make other viewers show glass."""
    return scene.material(
        name,
        {"type": "dielectric", "ior": ior, "priority": priority},
        extensions={
            "KHR_materials_ior": {"ior": ior},
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": thickness},
        },
    )


def experiment(defect):
    """defect: "clean", "bubble" or "dent"; or "exact", a flawless lens that is no mesh."""
    scene = Scene(
        "Report IES-2016-06, section 5: parallel light through a double-convex lens into a light "
        "field camera; " + defect + "."
    )
    material = glass(scene, "glass", IOR, THICKNESS)
    black = scene.material("black", {"type": "absorber"}, (0, 0, 0), doubleSided=True)
    scene.node(
        "camera",
        sensor={
            "type": "lightField",
            "focalLength": "50mm",
            "imageDistance": "60mm",
            "lensDiameter": "20mm",
            "spatialResolution": [160, 120],
            "angularResolution": [9, 9],
            "pixelSize": "4um",
        },
    )
    if defect == "exact":
        face = {"radius": "310mm", "semiDiameter": "14mm"}
        scene.node(
            "lens",
            translation=[0, 0, CENTRE - THICKNESS / 2],
            surface={
                "type": "lens",
                "surfaces": [
                    dict(face, thickness="6mm", material="glass"),
                    dict(face, radius="-310mm"),
                ],
                "rim": "glass",
            },
        )
        scene.node(
            "mount",
            translation=[0, 0, CENTRE],
            surface={"type": "disc", "radius": "30mm", "holeRadius": "14mm", "material": "black"},
        )
    else:
        lens_mesh = lens(
            scene,
            material,
            *((dented_sag, dent_radii()) if defect == "dent" else (sphere_sag, uniform_radii())),
        )
        mount_mesh = mount(scene, black)
        scene.node("lens", mesh=lens_mesh, translation=[0, 0, CENTRE])
        scene.node("mount", mesh=mount_mesh, translation=[0, 0, CENTRE])
    if defect == "bubble":
        air = glass(scene, "air", 1, 2 * BUBBLE_RADIUS, priority=1)
        scene.node(
            "bubble",
            mesh=scene.mesh("bubble", air, *ball(BUBBLE_RADIUS, 5)),
            translation=[0, 0, CENTRE],
        )
    # Half a turn about y: emitters shine along -z, the camera is on the other side.
    scene.node(
        "panel",
        translation=[0, 0, -0.384022],
        rotation=[0, 1, 0, 0],
        emitter={
            "type": "parallel",
            "size": ["60mm", "60mm"],
            "halfAngle": "0.5deg",
            "radiance": 1,
        },
    )
    return scene.gltf() if defect == "exact" else scene.glb()


def files():
    meshes = {
        "report-%s.glb" % defect: experiment(defect) for defect in ("clean", "bubble", "dent")
    }
    return dict(meshes, **{"report-exact.gltf": experiment("exact")})

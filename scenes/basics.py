# SPDX-License-Identifier: Apache-2.0
"""Small scenes to try things on: a box of diffuse walls, a glass ball in a uniform environment, a
thin lens's depth of field."""

from gltf import Scene, facing
from report import ball, glass


def box(low, high, outside=True):
    """Corners and triangles of an axis-parallel box, four corners a face so that it is flat; faces
    in the order -x +x -y +y -z +z."""
    positions, triangles = [], []
    for axis in range(3):
        for end in (0, 1):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            base = len(positions)
            for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = [0, 0, 0]
                p[axis], p[u], p[v] = (low, high)[end][axis], (low, high)[s][u], (low, high)[t][v]
                positions.append(tuple(p))
            # u x v = +axis: counter-clockwise from outside on the upper face, from inside on the
            # lower one.
            turned = (end == 1) != outside
            triangles += (
                [(base, base + 2, base + 1), (base, base + 3, base + 2)]
                if turned
                else [(base, base + 1, base + 2), (base, base + 2, base + 3)]
            )
    return positions, triangles


def square(half):
    """Corners and triangles of a square of the xy plane about the origin; it faces +z."""
    return [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [
        (0, 1, 2),
        (0, 2, 3),
    ]


def face(mesh, *indices):
    """The given faces of a box as a mesh of their own."""
    positions, triangles = mesh
    corners = [p for i in indices for p in positions[4 * i : 4 * i + 4]]
    return corners, [
        tuple(4 * k + corner - 4 * i for corner in t)
        for k, i in enumerate(indices)
        for t in triangles[2 * i : 2 * i + 2]
    ]


def diffuse(scene, name, *colour):
    return scene.material(
        name,
        {"type": "diffuse", "reflectance": list(colour) if len(colour) == 3 else colour[0]},
        colour if len(colour) == 3 else colour * 3,
    )


def diffuse_box():
    """A room of 0.2 m, open to the camera, with a red and a green wall, a block, a mirror cube, and
    an area light as ceiling lamp."""
    scene = Scene("A box of diffuse walls under an area light: interreflection.")
    room = box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1), outside=False)
    for name, colour, faces in (
        ("red", (0.6, 0.05, 0.05), [0]),
        ("green", (0.1, 0.45, 0.1), [1]),
        ("white", (0.7, 0.7, 0.7), [2, 3, 4]),
    ):
        scene.node(name, mesh=scene.mesh(name, diffuse(scene, name, *colour), *face(room, *faces)))
    block = scene.mesh(
        "block", diffuse(scene, "grey", 0.5), *box((-0.03, -0.06, -0.03), (0.03, 0.06, 0.03))
    )
    scene.node(
        "block", mesh=block, translation=[-0.035, -0.04, -0.035], rotation=facing((0.3, 0, -1))
    )
    cube = scene.mesh(
        "cube",
        scene.material("mirror", {"type": "mirror", "reflectance": 0.9}),
        *box((-0.03,) * 3, (0.03,) * 3),
    )
    scene.node("cube", mesh=cube, translation=[0.04, -0.07, 0.03], rotation=facing((-0.3, 0, -1)))
    scene.node(
        "light",
        translation=[0, 0.0999, 0],
        rotation=facing((0, -1, 0), up=(0, 0, 1)),
        emitter={"type": "area", "size": ["140mm", "140mm"], "radiance": 1},
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.4],
        sensor={
            "type": "pinhole",
            "imageDistance": "11.3mm",
            "resolution": [256, 256],
            "pixelSize": "30um",
        },
    )
    return scene.gltf()


def furnace():
    """Lossless glass with air inside it, under radiance 1 from everywhere: neither may be seen
    (each pixel is 1, but for what the depth limit cuts)."""
    scene = Scene("A glass ball around an air bubble in a uniform environment: every pixel is 1.")
    scene.node("ball", mesh=scene.mesh("ball", glass(scene, "glass", 1.5, 0.02), *ball(0.01, 3)))
    scene.node(
        "bubble",
        mesh=scene.mesh("bubble", glass(scene, "air", 1, 0.006, priority=1), *ball(0.003, 2)),
        translation=[0.004, 0, 0],
    )
    scene.node("environment", emitter={"type": "environment", "radiance": 1})
    scene.node(
        "camera",
        translation=[0, 0, 0.1],
        sensor={
            "type": "pinhole",
            "imageDistance": "20mm",
            "resolution": [128, 128],
            "pixelSize": "40um",
        },
    )
    return scene.glb()


def depth_of_field():
    """Gauge blocks at four depths, the second in focus, through a protective window; f/1.4 on a 1/2
    inch sensor, irradiance."""
    scene = Scene(
        "Gauge blocks at four depths before a thin lens, the second in focus, behind a protective "
        "window."
    )
    plate = scene.mesh(
        "plate",
        diffuse(scene, "plate", 0.2),
        [(-1, -0.03, -1), (1, -0.03, -1), (1, -0.03, 1), (-1, -0.03, 1)],
        [(0, 2, 1), (0, 3, 2)],
    )
    scene.node("plate", mesh=plate, translation=[0, 0, -0.4])
    block = scene.mesh(
        "block", diffuse(scene, "block", 0.8), *box((-0.012, -0.03, -0.012), (0.012, 0.03, 0.012))
    )
    for i, (x, z) in enumerate(((-0.036, -0.25), (-0.002, -0.30), (0.032, -0.38), (0.075, -0.50))):
        scene.node("block %d" % i, mesh=block, translation=[x, 0, z], rotation=facing((0.5, 0, -1)))
    window = scene.mesh(
        "window",
        scene.material(
            "window",
            {"type": "sheet", "ior": 1.52},
            doubleSided=True,
            extensions={"KHR_materials_transmission": {"transmissionFactor": 1}},
        ),
        *square(0.05),
    )
    scene.node("window", mesh=window, translation=[0, 0, -0.05])
    scene.node(
        "light",
        translation=[0.1, 0.3, -0.2],
        rotation=facing((-0.1, -0.3, -0.1)),
        emitter={"type": "area", "size": ["200mm", "200mm"], "radiance": 5},
    )
    scene.node("sky", emitter={"type": "environment", "radiance": 0.2})
    # Focus at 0.284 m, the front edge of the second block: 1/b = 1/f - 1/0.284.
    scene.node(
        "camera",
        sensor={
            "type": "thinLens",
            "focalLength": "16mm",
            "imageDistance": 0.016 / (1 - 0.016 / 0.284),
            "lensDiameter": 0.016 / 1.4,
            "resolution": [320, 240],
            "pixelSize": "20um",
            "radiometry": "irradiance",
        },
    )
    return scene.gltf()


def files():
    return {
        "diffuse-box.gltf": diffuse_box(),
        "furnace.glb": furnace(),
        "depth-of-field.gltf": depth_of_field(),
    }

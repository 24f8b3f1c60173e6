# SPDX-License-Identifier: Apache-2.0
"""Lights that no camera ray meets, or seldom: collimated beams, the points, spots and suns that
Blender exports, and light of 0.5° behind glass."""

from basics import box, diffuse, square
from gltf import Scene, facing
from images import stripes
from report import ball, glass


def beam():
    """A light sheet of 0.2 mm falls at 45° on a step, which breaks its line; beside it a round beam
    throws an image."""
    scene = Scene(
        "A light sheet breaks at a step; a round collimated beam throws an image without blur."
    )
    scene.node("plate", mesh=scene.mesh("plate", diffuse(scene, "plate", 0.6), *square(0.05)))
    scene.node(
        "block",
        mesh=scene.mesh(
            "block", diffuse(scene, "block", 0.6), *box((-0.008, -0.01, 0), (0.008, 0.01, 0.005))
        ),
        translation=[-0.012, 0, 0],
    )
    scene.node(
        "sheet",
        translation=[-0.012, -0.08, 0.08],
        rotation=facing((0, 0.08, -0.08), up=(0, 0, 1)),
        emitter={"type": "collimatedBeam", "size": ["40mm", "0.2mm"], "irradiance": 20},
    )
    scene.node(
        "beam",
        translation=[0.022, -0.08, 0.08],
        rotation=facing((0, 0.08, -0.08), up=(0, 0, 1)),
        emitter={
            "type": "collimatedBeam",
            "size": ["16mm", "16mm"],
            "aperture": "circle",
            "image": scene.image("pattern", stripes(40, 40)),
            "power": 0.001,
        },
    )
    scene.node("sky", emitter={"type": "environment", "radiance": 0.1})
    scene.node(
        "camera",
        translation=[0, 0, 0.15],
        sensor={
            "type": "telecentric",
            "magnification": 0.2,
            "workingDistance": "150mm",
            "fNumber": 8,
            "resolution": [320, 240],
            "pixelSize": "48um",
        },
    )
    return scene.gltf()


def punctual():
    """A desk under a spot, a point and a directional light of KHR_lights_punctual, in candela and
    lux."""
    scene = Scene(
        "A spot, a point and a directional light as Blender exports them (KHR_lights_punctual)."
    )
    scene.node(
        "desk",
        mesh=scene.mesh(
            "desk",
            diffuse(scene, "desk", 0.6),
            [(-0.5, 0, -0.5), (-0.5, 0, 0.5), (0.5, 0, 0.5), (0.5, 0, -0.5)],
            [(0, 1, 2), (0, 2, 3)],
        ),
    )
    scene.node(
        "block",
        mesh=scene.mesh(
            "block", diffuse(scene, "block", 0.5), *box((-0.05, 0, -0.05), (0.05, 0.12, 0.05))
        ),
        rotation=facing((0.4, 0, -1)),
    )
    scene.node(
        "spot",
        translation=[-0.3, 0.5, 0.2],
        rotation=facing((0.35, -0.5, -0.1)),
        light={
            "type": "spot",
            "color": [1, 0.8, 0.6],
            "intensity": 683,
            "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.35},
        },
    )
    scene.node(
        "point",
        translation=[0.25, 0.15, 0.1],
        light={"type": "point", "color": [0.5, 0.7, 1], "intensity": 40, "range": 1.5},
    )
    scene.node(
        "sun", rotation=facing((-0.3, -1, -0.5)), light={"type": "directional", "intensity": 400}
    )
    scene.node(
        "camera",
        translation=[0, 0.45, 0.7],
        rotation=facing((0, -0.4, -0.7)),
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [320, 240],
            "pixelSize": "30um",
        },
    )
    return scene.gltf()


def sky_rows(width, height):
    """A blue sky that pales towards the horizon, a sun of 2 x 2 pixels and a brown ground: row 0 on
    top."""
    rows = []
    for y in range(height):
        row = []
        for x in range(width):
            if y >= height // 2:
                row.append((70, 55, 40))
            elif x in (44, 45) and y in (9, 10):
                row.append((255, 255, 255))
            else:
                pale = 2 * y / height
                row.append((round(10 + 40 * pale), round(16 + 40 * pale), round(36 + 24 * pale)))
        rows.append(row)
    return rows


def sky():
    """A diffuse and a mirror block under an image of the sky by longitude and latitude, whose sun
    throws shadows."""
    scene = Scene(
        "An environment with an image lights two blocks: one is diffuse, one shows the sky."
    )
    scene.node(
        "ground",
        mesh=scene.mesh(
            "ground",
            diffuse(scene, "ground", 0.5),
            [(-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)],
            [(0, 1, 2), (0, 2, 3)],
        ),
    )
    scene.node(
        "block",
        mesh=scene.mesh(
            "block", diffuse(scene, "block", 0.6), *box((-0.05, 0, -0.05), (0.05, 0.12, 0.05))
        ),
        translation=[-0.1, 0, 0],
        rotation=facing((0.4, 0, -1)),
    )
    mirror = scene.material("mirror", {"type": "mirror", "reflectance": 0.9})
    scene.node(
        "mirror",
        mesh=scene.mesh("mirror", mirror, *box((-0.05, 0, -0.05), (0.05, 0.12, 0.05))),
        translation=[0.1, 0, 0],
        rotation=facing((-0.4, 0, -1)),
    )
    scene.node(
        "sky",
        emitter={
            "type": "environment",
            "image": scene.image("sky", sky_rows(64, 32)),
            "radiance": 20,
        },
    )
    scene.node(
        "camera",
        translation=[0, 0.3, 0.6],
        rotation=facing((0, -0.25, -0.6)),
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [320, 240],
            "pixelSize": "30um",
        },
    )
    return scene.gltf()


def caustic():
    """A glass ball on paper in slanting light of 0.5°, like the sun's; a diffuse panel above lights
    the rest."""
    scene = Scene(
        "A glass ball gathers light of 0.5° into a caustic on paper; emitters lamp and panel."
    )
    scene.node("paper", mesh=scene.mesh("paper", diffuse(scene, "paper", 0.8), *square(0.1)))
    scene.node(
        "ball",
        mesh=scene.mesh("ball", glass(scene, "glass", 1.517, 0.02), *ball(0.010, 5)),
        translation=[-0.008, 0, 0.0105],
    )
    scene.node(
        "lamp",
        translation=[-0.088, 0, 0.1058],
        rotation=facing((0.08, 0, -0.0953), up=(0, 1, 0)),
        emitter={
            "type": "parallel",
            "size": ["60mm", "60mm"],
            "halfAngle": "0.25deg",
            "power": 0.0043,
        },
    )
    scene.node(
        "panel",
        translation=[0, 0.12, 0.12],
        rotation=facing((0, -0.12, -0.12)),
        emitter={"type": "area", "size": ["80mm", "80mm"], "radiance": 0.15},
    )
    scene.node(
        "camera",
        translation=[0.012, -0.11, 0.14],
        rotation=facing((-0.010, 0.115, -0.14)),
        sensor={
            "type": "thinLens",
            "focalLength": "25mm",
            "focusDistance": "178mm",
            "fNumber": 8,
            "resolution": [280, 210],
            "pixelSize": "36um",
        },
    )
    return scene.gltf()


def files():
    return {
        "beam.gltf": beam(),
        "caustic.gltf": caustic(),
        "punctual.gltf": punctual(),
        "sky.gltf": sky(),
    }

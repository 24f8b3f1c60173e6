# SPDX-License-Identifier: Apache-2.0
"""What surfaces do to light: brushed metal, rough and coated glass, retroreflecting tape in a
coaxial set-up."""

import math

from basics import diffuse
from gltf import Scene, facing
from report import ball

WAVELENGTHS = ["611.4nm", "549.1nm", "464.2nm"]


def plate(scene, name, material, x0, y0, x1, y1, z=0, texcoords=None):
    """A rectangle that faces +z."""
    return scene.node(
        name,
        mesh=scene.mesh(
            name,
            material,
            [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)],
            [(0, 1, 2), (0, 2, 3)],
            texcoords=texcoords,
        ),
    )


def ring(count, inner, outer):
    """A flat ring facing +z with texture coordinates along the circle: u runs around, so that
    tangents do."""
    positions, texcoords, triangles = [], [], []
    for i in range(count + 1):
        angle = 2 * math.pi * i / count
        for j, r in enumerate((inner, outer)):
            positions.append((r * math.cos(angle), r * math.sin(angle), 0))
            texcoords.append((8 * i / count, j))
    for i in range(count):
        triangles += [(2 * i, 2 * i + 1, 2 * i + 3), (2 * i, 2 * i + 3, 2 * i + 2)]
    return positions, triangles, texcoords


def brushed():
    """Discs of aluminium, copper and gold, turned on a lathe, on a sheet of brushed steel."""
    scene = Scene(
        "Turned discs of three metals on a brushed sheet under a small lamp: highlights lie "
        "across the grooves."
    )
    scene.wavelengths = WAVELENGTHS
    iron = scene.material(
        "sheet",
        {
            "type": "conductor",
            "metal": "iron",
            "roughness": 0.3,
            "anisotropy": 0.7,
            "anisotropyRotation": "90deg",
        },
    )
    plate(
        scene,
        "sheet",
        iron,
        -0.12,
        -0.09,
        0.12,
        0.09,
        -0.0005,
        texcoords=[(0, 1), (1, 1), (1, 0), (0, 0)],
    )
    for i, metal in enumerate(("aluminium", "copper", "gold")):
        # Grooves run around: the surface is rougher across them.
        disc = scene.material(
            metal,
            {
                "type": "conductor",
                "metal": metal,
                "roughness": 0.25,
                "anisotropy": 0.75,
                "anisotropyRotation": "90deg",
            },
        )
        positions, triangles, texcoords = ring(96, 0.004, 0.03)
        scene.node(
            metal,
            mesh=scene.mesh(
                metal, disc, positions, triangles, [(0, 0, 1)] * len(positions), texcoords
            ),
            translation=[0.07 * (i - 1), 0, 0],
        )
    scene.node(
        "lamp",
        translation=[0.05, 0.15, 0.25],
        rotation=facing((-0.05, -0.15, -0.25)),
        emitter={"type": "area", "size": ["40mm", "40mm"], "radiance": [31, 30, 28]},
    )
    scene.node("sky", emitter={"type": "environment", "radiance": 0.15})
    scene.node(
        "camera",
        translation=[0, -0.12, 0.30],
        rotation=facing((0, 0.12, -0.30)),
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [320, 200],
            "pixelSize": "30um",
        },
    )
    return scene.gltf()


def glasses():
    """Four balls of glass before a striped wall: clear, coated, finely and coarsely ground."""
    scene = Scene("Balls of glass, clear, coated, roughness 0.15 and 0.4, before stripes.")
    light, dark = diffuse(scene, "light", 0.8), diffuse(scene, "dark", 0.05)
    for i in range(16):
        x = -0.16 + 0.02 * i
        plate(scene, "stripe %d" % i, (light, dark)[i % 2], x, -0.06, x + 0.02, 0.06, -0.06)
    kinds = (
        ("clear", {}),
        ("coated", {"coating": 0.003}),
        ("fine", {"roughness": 0.15}),
        ("coarse", {"roughness": 0.4}),
    )
    for i, (name, more) in enumerate(kinds):
        glass = scene.material(name, dict({"type": "dielectric", "ior": 1.5}, **more))
        scene.node(
            name,
            mesh=scene.mesh(name, glass, *ball(0.018, 4)),
            translation=[0.045 * (i - 1.5), 0, 0],
        )
    scene.node(
        "lamp",
        translation=[-0.1, 0.2, 0.15],
        rotation=facing((0.1, -0.2, -0.15)),
        emitter={"type": "area", "size": ["200mm", "200mm"], "radiance": 1},
    )
    scene.node("sky", emitter={"type": "environment", "radiance": 0.3})
    scene.node(
        "camera",
        translation=[0, 0, 0.3],
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [320, 140],
            "pixelSize": "27um",
        },
    )
    return scene.gltf()


def tape():
    """White paint and retroreflecting tape on panels turned away by 0°, 20°, 40° and 60°, seen and
    lit through a half mirror."""
    scene = Scene(
        "Tape and white paint, turned by 0, 20, 40, 60 degrees, in a coaxial set-up: the tape "
        "shines, whatever its angle; the paint is dark."
    )
    paint = diffuse(scene, "paint", 0.8)
    reflex = scene.material(
        "tape",
        {
            "type": "retroreflector",
            "reflectance": 0.45,
            "entranceAngle": "40deg",
            "divergence": "0.4deg",
            "diffuseReflectance": 0.1,
        },
    )
    plate(scene, "table", diffuse(scene, "table", 0.05), -0.03, -0.02, 0.03, 0.02, -0.01)
    for i in range(4):
        angle = math.radians(20 * i)
        turn = facing((-math.sin(angle), 0, -math.cos(angle)))
        for name, material, y in (("paint", paint, -0.0045), ("tape", reflex, 0.0045)):
            mesh = scene.mesh(
                "%s %d" % (name, 20 * i),
                material,
                [
                    (-0.003, -0.0035, 0),
                    (0.003, -0.0035, 0),
                    (0.003, 0.0035, 0),
                    (-0.003, 0.0035, 0),
                ],
                [(0, 1, 2), (0, 2, 3)],
            )
            scene.node(
                "%s %d" % (name, 20 * i),
                mesh=mesh,
                translation=[0.0075 * (i - 1.5), y, 0],
                rotation=turn,
            )
    scene.node(
        "coaxial",
        translation=[0, 0, 0.05],
        emitter={"type": "coaxial", "size": ["44mm", "44mm"], "halfAngle": "15deg", "radiance": 1},
    )
    # Off, until a picture is to show what light from aside does.
    scene.node(
        "lamp",
        translation=[0.2, 0, 0.15],
        rotation=facing((-0.2, 0, -0.15)),
        emitter={"type": "area", "size": ["40mm", "40mm"], "radiance": 0},
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.150],
        sensor={
            "type": "telecentric",
            "magnification": 0.25,
            "workingDistance": "150mm",
            "fNumber": 8,
            "resolution": [320, 200],
            "pixelSize": "25um",
        },
    )
    return scene.gltf()


def files():
    return {"brushed.gltf": brushed(), "glasses.gltf": glasses(), "tape.gltf": tape()}

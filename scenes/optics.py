# SPDX-License-Identifier: Apache-2.0
"""Exact lenses and bodies of catalogue glass: a loupe with and without colours, a prism, a rod in
fluid, a coated window, a diffuser."""

import math

from basics import diffuse, square
from gltf import Scene, facing
from surfaces import WAVELENGTHS, plate


def body(scene, name, glass, **more):
    return scene.material(name, dict({"type": "dielectric", "glass": glass}, **more))


def loupe():
    """Two loupes of f = 100 mm over bars on a light table, each before a camera of its own: a
    biconvex lens of N-SF11 and a cemented achromat, N-BK7 and SF5, the prescription of a common
    catalogue lens (62.75, -45.71, -128.23 mm; 4 and 2.5 mm)."""
    scene = Scene(
        "Bars through a single lens of flint and through an achromat, f 100 mm: red and blue come "
        "apart through the first."
    )
    scene.wavelengths = WAVELENGTHS
    for name, glass in (("flint", "N-SF11"), ("crown", "N-BK7"), ("dense", "SF5")):
        body(scene, name, glass)
    black = scene.material("black", {"type": "absorber"}, (0, 0, 0))
    edge = {"semiDiameter": "12.7mm"}
    lenses = {
        "singlet": [
            dict(edge, radius="156.3mm", thickness="3.5mm", material="flint"),
            dict(edge, radius="-156.3mm"),
        ],
        "achromat": [
            dict(edge, radius="62.75mm", thickness="4mm", material="crown"),
            dict(edge, radius="-45.71mm", thickness="2.5mm", material="dense"),
            dict(edge, radius="-128.23mm"),
        ],
    }
    for name, surfaces, x in (
        ("singlet", lenses["singlet"], -0.05),
        ("achromat", lenses["achromat"], 0.05),
    ):
        scene.node(
            name + " table",
            translation=[x, 0, -0.001],
            rotation=facing((0, 0, 1)),
            emitter={"type": "area", "size": ["60mm", "60mm"], "radiance": 1},
        )
        for i in range(-3, 4):
            plate(
                scene,
                "%s bar %d" % (name, i),
                black,
                x + 0.006 * i - 0.0015,
                -0.02,
                x + 0.006 * i + 0.0015,
                0.02,
            )
        # The strong surface of the achromat looks to the camera, which is the far side: half a turn
        # about y.
        scene.node(
            name + " lens",
            translation=[x, 0, 0.080],
            rotation=[0, 1, 0, 0],
            surface={"type": "lens", "surfaces": surfaces},
        )
        scene.node(
            name,
            translation=[x, 0, 0.140],
            sensor={
                "type": "pinhole",
                "imageDistance": "12mm",
                "resolution": [224, 168],
                "pixelSize": "18um",
            },
        )
    return scene.gltf()


def prism():
    """A white beam through a prism of N-SF11 in its least deviation, onto a screen 150 mm behind: a
    line for each of the three wavelengths."""
    scene = Scene(
        "A white beam through a prism of N-SF11 onto a screen: one line for each wavelength of "
        "the scene."
    )
    scene.wavelengths = WAVELENGTHS
    glass = body(scene, "glass", "N-SF11")
    side, depth, incidence = 0.020, 0.010, math.asin(1.7912 / 2)  # of the 549 nm line
    h = side * math.sqrt(3) / 2
    corners = [(-side / 2, 0), (side / 2, 0), (0, h)]
    positions = [(x, y, z) for z in (-depth, depth) for x, y in corners]
    sides = [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5)]
    flat = [[positions[i] for i in triangle] for triangle in [(0, 2, 1), (3, 4, 5)] + sides]
    scene.node(
        "prism",
        mesh=scene.mesh(
            "prism",
            glass,
            [p for t in flat for p in t],
            [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(flat))],
        ),
    )
    up = incidence - math.pi / 6  # into it the beam climbs, out of it it falls
    into, out = (math.cos(up), math.sin(up), 0), (math.cos(up), -math.sin(up), 0)
    enters, leaves = (-side / 4, h / 2, 0), (side / 4, h / 2, 0)
    scene.node(
        "beam",
        translation=[enters[k] - 0.06 * into[k] for k in range(3)],
        rotation=facing(into, (0, 0, 1)),
        emitter={"type": "collimatedBeam", "size": ["0.5mm", "8mm"], "irradiance": 1},
    )
    screen = [leaves[k] + 0.15 * out[k] for k in range(3)]
    paper = diffuse(scene, "paper", 0.8)
    mesh = scene.mesh("screen", paper, *square(0.02))
    scene.node("screen", mesh=mesh, translation=screen, rotation=facing(out))
    camera = [screen[0] - 0.07 * out[0], screen[1] - 0.07 * out[1], 0.05]
    scene.node(
        "camera",
        translation=camera,
        rotation=facing([screen[k] - camera[k] for k in range(3)]),
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [224, 168],
            "pixelSize": "18um",
        },
    )
    return scene.gltf()


def immersion():
    """A rod of N-BK7 with a bubble, in a cuvette of a fluid of its index, before a backlight:
    bodies in bodies, by priority."""
    scene = Scene(
        "A glass rod with a bubble in a cuvette: in fluid of its own index the rod is gone and "
        "the bubble stays."
    )
    scene.material("fluid", {"type": "dielectric", "ior": 1.5168})
    body(scene, "rod", "N-BK7", priority=1)
    scene.material("air", {"type": "dielectric", "ior": 1, "priority": 2})
    scene.node(
        "cuvette",
        surface={
            "type": "box",
            "width": "40mm",
            "height": "30mm",
            "depth": "20mm",
            "material": "fluid",
        },
    )
    scene.node(
        "rod",
        rotation=facing((1, 0, 0)),
        surface={"type": "cylinder", "radius": "5mm", "length": "36mm", "material": "rod"},
    )
    scene.node(
        "bubble",
        translation=[0.002, 0.0025, 0.001],
        surface={"type": "sphere", "radius": "0.3mm", "material": "air"},
    )
    scene.node(
        "backlight",
        translation=[0, 0, -0.04],
        rotation=[0, 1, 0, 0],
        emitter={"type": "parallel", "size": ["50mm", "40mm"], "halfAngle": "2deg", "radiance": 1},
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.1],
        sensor={
            "type": "telecentric",
            "magnification": 0.25,
            "workingDistance": "95mm",
            "fNumber": 8,
            "resolution": [224, 168],
            "pixelSize": "16um",
        },
    )
    return scene.gltf()


def window():
    """A chart behind a window, in which the camera sees a lamp mirrored: with the coating of the
    file, a tenth of what bare glass mirrors."""
    scene = Scene("A chart behind a coated window with a lamp mirrored in it.")
    body(scene, "pane", "N-BK7", coating=0.004)
    white, black = diffuse(scene, "white", 0.6), diffuse(scene, "black", 0.03)
    plate(scene, "paper", white, -0.04, -0.03, 0.04, 0.03, -0.01)
    for i in range(-4, 5):
        plate(
            scene, "bar %d" % i, black, 0.008 * i - 0.002, -0.02, 0.008 * i + 0.002, 0.02, -0.0095
        )
    scene.node(
        "window",
        surface={
            "type": "box",
            "width": "80mm",
            "height": "60mm",
            "depth": "3mm",
            "material": "pane",
        },
    )
    scene.node(
        "lamp",
        translation=[0.02, 0.12, 0.2],
        rotation=facing((-0.02, -0.12, -0.2)),
        emitter={"type": "area", "size": ["30mm", "30mm"], "radiance": 10},
    )
    scene.node("sky", emitter={"type": "environment", "radiance": 0.3})
    scene.node(
        "camera",
        translation=[0, -0.12, 0.2],
        rotation=facing((0, 0.12, -0.2)),
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [224, 168],
            "pixelSize": "18um",
        },
    )
    return scene.gltf()


def diffuser():
    """Sixteen small lamps behind a plate of opal, seen from the front."""
    scene = Scene(
        "Lamps behind an opal plate: an even backlight, which they are not behind a clear one."
    )
    opal = scene.material("plate", {"type": "diffuse", "reflectance": 0.35, "transmittance": 0.6})
    plate(scene, "plate", opal, -0.04, -0.03, 0.04, 0.03)
    white = diffuse(scene, "white", 0.9)
    plate(scene, "floor", white, -0.04, -0.03, 0.04, 0.03, -0.03)
    walls = [
        ((-0.04, -0.03), (0.04, -0.03)),
        ((0.04, -0.03), (0.04, 0.03)),
        ((0.04, 0.03), (-0.04, 0.03)),
        ((-0.04, 0.03), (-0.04, -0.03)),
    ]
    for i, (a, b) in enumerate(walls):
        scene.node(
            "wall %d" % i,
            mesh=scene.mesh(
                "wall %d" % i,
                white,
                [(*a, -0.03), (*b, -0.03), (*b, 0), (*a, 0)],
                [(0, 2, 1), (0, 3, 2)],
            ),
        )
    for i in range(16):
        x, y = 0.02 * (i % 4 - 1.5), 0.015 * (i // 4 - 1.5)
        scene.node(
            "lamp %d" % i,
            translation=[x, y, -0.029],
            rotation=[0, 1, 0, 0],
            emitter={"type": "area", "size": ["3mm", "3mm"], "radiance": 10},
        )
    scene.node(
        "camera",
        translation=[0, 0, 0.2],
        sensor={
            "type": "pinhole",
            "imageDistance": "12mm",
            "resolution": [224, 168],
            "pixelSize": "21um",
        },
    )
    return scene.gltf()


def files():
    return {
        "loupe.gltf": loupe(),
        "prism.gltf": prism(),
        "immersion.gltf": immersion(),
        "window.gltf": window(),
        "diffuser.gltf": diffuser(),
    }

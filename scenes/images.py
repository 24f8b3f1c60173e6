# SPDX-License-Identifier: Apache-2.0
"""What emitters with an image show: a coded pattern thrown on a step, and a light field display
before a light field camera."""

from basics import box, diffuse, square
from gltf import Scene, facing


def stripes(width, height):
    """Bars of four pixels under a letter F in red, which has neither symmetry nor a likeness when
    mirrored: row 0 on top."""
    letter = ("XXXXXX", "X.....", "XXXX..", "X.....", "X.....", "X.....")
    rows = []
    for y in range(height):
        row = []
        for x in range(width):
            bar = 255 if x // 4 % 2 == 0 else 40
            column, line = (x - 4) // 2, (y - 4) // 2
            on = 0 <= line < len(letter) and 0 <= column < 6 and letter[line][column] == "X"
            row.append((255, 30, 20) if on else (bar, bar, bar))
        rows.append(row)
    return rows


def projector():
    """A pattern of 32 x 20 mm falls from the left on a plate with a block, which shifts the bars;
    seen from above by a telecentric camera."""
    scene = Scene(
        "A telecentric projector throws bars and a letter on a plate with a block: the height "
        "shifts the pattern."
    )
    scene.node("plate", mesh=scene.mesh("plate", diffuse(scene, "plate", 0.6), *square(0.05)))
    scene.node(
        "block",
        mesh=scene.mesh(
            "block", diffuse(scene, "block", 0.6), *box((-0.006, -0.005, 0), (0.006, 0.005, 0.004))
        ),
        translation=[0.004, -0.002, 0],
    )
    # Up is +y here and at the camera, and both look from the same side: the letter reads right.
    scene.node(
        "projector",
        translation=[-0.05, 0, 0.1],
        rotation=facing((0.05, 0, -0.1)),
        emitter={
            "type": "telecentricProjector",
            "image": scene.image("pattern", stripes(64, 40)),
            "size": ["32mm", "20mm"],
            "halfAngle": "0.1deg",
            "power": 0.01,
        },
    )
    scene.node(
        "light",
        translation=[0.1, 0.1, 0.2],
        rotation=facing((-0.1, -0.1, -0.2)),
        emitter={"type": "area", "size": ["40mm", "40mm"], "radiance": 1},
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.15],
        sensor={
            "type": "telecentric",
            "magnification": 0.2,
            "workingDistance": "150mm",
            "fNumber": 8,
            "resolution": [320, 240],
            "pixelSize": "24um",
        },
    )
    return scene.gltf()


def lens_projector():
    """A projector of f 16 mm throws a picture of 64 x 40 mm on a plate with a tall block, 0.25 m
    away: sharp below, blurred on the block."""
    scene = Scene(
        "A projector with a lens: its picture is sharp on the plate and blurred on the block, "
        "which stands before its focus."
    )
    scene.node("plate", mesh=scene.mesh("plate", diffuse(scene, "plate", 0.6), *square(0.05)))
    scene.node(
        "block",
        mesh=scene.mesh(
            "block", diffuse(scene, "block", 0.6), *box((-0.01, -0.008, 0), (0.01, 0.008, 0.03))
        ),
        translation=[0.012, -0.006, 0],
    )
    # b = f w/(w - f) = 17.094 mm, so that 64 pixels of 68.376 um become 64 mm.
    scene.node(
        "projector",
        translation=[-0.06, 0, 0.24269322],
        rotation=facing((0.06, 0, -0.24269322)),
        emitter={
            "type": "projector",
            "image": scene.image("pattern", stripes(64, 40)),
            "focalLength": "16mm",
            "focusDistance": "250mm",
            "lensDiameter": "12mm",
            "pixelSize": "68.376um",
            "power": 0.01,
        },
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.15],
        sensor={
            "type": "telecentric",
            "magnification": 0.1,
            "workingDistance": "135mm",
            "fNumber": 8,
            "resolution": [320, 240],
            "pixelSize": "24um",
        },
    )
    return scene.gltf()


def views(macro, angular):
    """M x N macro pixels of J x K directions: red grows with the column of the macro pixel, green
    with its row, and a disk moves over the display with the direction."""
    rows = []
    for y in range(macro[1] * angular[1]):
        row = []
        for x in range(macro[0] * angular[0]):
            m, j = divmod(x, angular[0])
            n, k = divmod(y, angular[1])
            # Where the disk is seen from direction (j, k), in macro pixels.
            at_x = macro[0] / 2 + (j - (angular[0] - 1) / 2) * 0.8
            at_y = macro[1] / 2 + (k - (angular[1] - 1) / 2) * 0.8
            inside = (m + 0.5 - at_x) ** 2 + (n + 0.5 - at_y) ** 2 < 9
            row.append(
                (255, 255, 255)
                if inside
                else (30 + 200 * m // macro[0], 30 + 200 * n // macro[1], 60)
            )
        rows.append(row)
    return rows


def light_field():
    """A display of 24 x 18 macro pixels, 7 x 7 directions each, in the focus of a light field
    camera of the same pitch."""
    macro, angular = (24, 18), (7, 7)
    scene = Scene(
        "A light field emitter faces a light field camera: each camera pixel sees one direction "
        "of one macro pixel."
    )
    # The lens of 30 mm is seen from 300 mm at sines up to 0.05; the display's 24 mm half-width adds
    # 0.08.
    scene.node(
        "display",
        emitter={
            "type": "lightField",
            "image": scene.image("views", views(macro, angular)),
            "size": ["48mm", "36mm"],
            "spatialResolution": list(macro),
            "angularResolution": list(angular),
            "angularRange": 0.14,
            "radiance": 1,
        },
    )
    # f 50 mm, b 60 mm: in focus at 300 mm at a scale of 0.2; 7 pixels are a macro pixel of 0.4 mm.
    scene.node(
        "camera",
        translation=[0, 0, -0.3],
        rotation=facing((0, 0, 1)),
        sensor={
            "type": "lightField",
            "focalLength": "50mm",
            "imageDistance": "60mm",
            "lensDiameter": "30mm",
            "spatialResolution": list(macro),
            "angularResolution": list(angular),
            "pixelSize": 0.0004 / 7,
        },
    )
    return scene.gltf()


def files():
    return {
        "projector.gltf": projector(),
        "lens-projector.gltf": lens_projector(),
        "light-field.gltf": light_field(),
    }

# SPDX-License-Identifier: Apache-2.0
"""A CAD assembly, 2CylinderEngine.glb, seen through a telecentric lens: against a parallel
backlight, and under area lights.

The model is 745 units long and glTF's unit is the metre: its millimetres were exported as metres. A
node of scale 0.0001 makes it a model of 75 mm, which a telecentric lens can see. The scenes hold
the model's JSON; their buffer is the .glb itself (glTF lets a buffer be any file), so its bytes are
here once and stay as they were published.

Camera: a 2/3 inch sensor binned to pixels of 6.9 µm, of which 1200 x 600 are read; m = 0.1, so the
field is 82.8 x 41.4 mm and a pixel 69 µm of the object. Working f-number 16: NA = m/(2N) = 0.0031,
sharp within a pixel to ±11 mm."""

import json
import os
import struct

from gltf import Scene, dumped, facing

SOURCE = "2CylinderEngine.glb"
SCALE = 0.0001
CENTRE = (0, -44.464966, -6)  # of the model's bounding box, in its units

CAMERA = {
    "type": "telecentric",
    "magnification": 0.1,
    "workingDistance": "150mm",
    "fNumber": 16,
    "resolution": [1200, 600],
    "pixelSize": "6.9um",
}


def model():
    """The model's JSON without its camera, its buffer views moved to where the binary chunk lies in
    the file."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), SOURCE), "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    tree = json.loads(data[20 : 20 + length])
    assert (
        tree.pop("cameras")
        and "camera" in tree["nodes"][-1]
        and tree["scenes"][0]["nodes"] == [len(tree["nodes"]) - 1, 0]
    )
    tree["nodes"].pop()
    for view in tree["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + 28 + length
    tree["buffers"] = [{"uri": SOURCE, "byteLength": len(data)}]
    return tree


def wrapped(scene, roots):
    """The scene's text: the model, scaled and centred in the origin, and what `scene` puts around
    it."""
    tree, around = model(), scene.tree(roots)
    assert "meshes" not in around
    around["asset"][
        "copyright"
    ] = "Model: ASSIMP Development Team, 3-clause BSD licence, see 2CylinderEngine.LICENSE"
    first = len(tree["nodes"])
    part = {
        "name": "part",
        "children": [0],
        "scale": [SCALE] * 3,
        "translation": [-SCALE * c for c in CENTRE],
    }
    nodes = [
        dict(
            node,
            **(
                {"children": [first + child for child in node["children"]]}
                if "children" in node
                else {}
            ),
        )
        for node in around["nodes"]
    ]
    tree["nodes"] += nodes + [part]
    tree["scenes"] = [{"nodes": [first + root for root in roots] + [len(tree["nodes"]) - 1]}]
    return dumped(
        {
            **{key: around[key] for key in ("asset", "extensionsUsed", "extensions")},
            "scene": 0,
            **{
                key: tree[key]
                for key in (
                    "scenes",
                    "nodes",
                    "materials",
                    "meshes",
                    "accessors",
                    "bufferViews",
                    "buffers",
                )
            },
        }
    ).encode()


def backlight():
    """From the front, the fins in silhouette. The panel's cone, 1°, is wider than the camera's,
    0.18°."""
    scene = Scene("Telecentric view of 2CylinderEngine.glb against a parallel backlight.")
    roots = [
        scene.node("camera", sensor=CAMERA, translation=[0, 0, 0.15]),
        scene.node(
            "backlight",
            translation=[0, 0, -0.06],
            rotation=[0, 1, 0, 0],
            emitter={
                "type": "parallel",
                "size": ["100mm", "60mm"],
                "halfAngle": "1deg",
                "radiance": 1,
            },
        ),
    ]
    return wrapped(scene, roots)


def area_light():
    """From the front, above and the left: a large light above the camera, a weaker one to the
    right, a bright field behind."""
    scene = Scene("Telecentric view of 2CylinderEngine.glb under area lights.")
    parts = [
        scene.node("camera", sensor=CAMERA, translation=[0, 0.0016, 0.15])
    ]  # seen from here the part's middle lies higher
    for name, at, size, radiance in (
        ("key", [-0.10, 0.16, 0.12], ["120mm", "120mm"], 3),
        ("fill", [0.20, 0.02, 0.10], ["80mm", "80mm"], 3),
        ("field", [0, 0, -0.08], ["120mm", "80mm"], 0.1),
    ):
        parts.append(
            scene.node(
                name,
                translation=at,
                rotation=facing([-c for c in at]),
                emitter={"type": "area", "size": size, "radiance": radiance},
            )
        )
    rig = scene.node("rig", rotation=facing([0.5, -0.5, -1]), children=parts)
    return wrapped(scene, [rig])


def files():
    return {"part-backlight.gltf": backlight(), "part-arealight.gltf": area_light()}

# SPDX-License-Identifier: Apache-2.0
"""Writing glTF 2.0 with the standard library alone: meshes into one binary chunk, JSON around
it."""

import base64
import json
import math
import struct
import zlib

FLOAT, U16, U32 = 5126, 5123, 5125
VERTICES, INDICES = 34962, 34963


def rounded(x):
    """x as the nearest float32, the precision in which it is stored."""
    return struct.unpack("<f", struct.pack("<f", x))[0]


def dumped(tree):
    """JSON text with one element a line: made to be read and to be compared."""

    def value(x):
        return json.dumps(x, separators=(", ", ": "), ensure_ascii=False)

    def member(key, x):
        if isinstance(x, list) and x and isinstance(x[0], dict):
            return value(key) + ": [\n    " + ",\n    ".join(map(value, x)) + "\n  ]"
        return value(key) + ": " + value(x)

    return "{\n  " + ",\n  ".join(member(*item) for item in tree.items()) + "\n}\n"


def png(rows):
    """A PNG of rows of (R, G, B) bytes, row 0 on top. Stored without compression: the same bytes
    from every zlib."""

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    raw = b"".join(b"\0" + bytes(value for pixel in row for value in pixel) for row in rows)
    blocks = [raw[i : i + 65535] for i in range(0, len(raw), 65535)]
    deflated = b"".join(
        struct.pack("<BHH", block is blocks[-1], len(block), len(block) ^ 0xFFFF) + block
        for block in blocks
    )
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0))
        + chunk(b"IDAT", b"\x78\x01" + deflated + struct.pack(">I", zlib.adler32(raw)))
        + chunk(b"IEND", b"")
    )


class Scene:
    """A glTF file in the making. The lists are glTF's; MCVISI_ objects on nodes are gathered into
    their root arrays."""

    def __init__(self, note):
        self.asset = {"version": "2.0", "generator": "scenes/generate.py", "extras": {"note": note}}
        self.nodes, self.meshes, self.materials = [], [], []
        self.accessors, self.views, self.binary = [], [], bytearray()
        self.images, self.textures, self.lights = [], [], []
        self.elements = {}  # "sensor", "emitter" or "surface" -> its root array
        self.wavelengths = None
        self.extensions = set()

    def material(self, name, mcvisi, base_colour=(1, 1, 1), extensions=None, **more):
        """A material with its MCVISI_materials object and core properties for other viewers;
        returns its index."""
        extensions = dict(extensions or {}, MCVISI_materials=mcvisi)
        self.extensions.update(extensions)
        self.materials.append(
            {
                "name": name,
                "pbrMetallicRoughness": {"baseColorFactor": [*base_colour, 1], "metallicFactor": 0},
                **more,
                "extensions": extensions,
            }
        )
        return len(self.materials) - 1

    def metal(self, name, roughness, image=None, colour=1):
        """A core glTF metal, of one grey or as an image has it; returns its index."""
        pbr = {
            "metallicFactor": 1,
            "roughnessFactor": roughness,
            "baseColorFactor": [colour, colour, colour, 1],
        }
        if image:
            pbr["baseColorTexture"] = {"index": len(self.textures)}
            self.textures.append({"source": [i["name"] for i in self.images].index(image)})
        self.materials.append({"name": name, "pbrMetallicRoughness": pbr})
        return len(self.materials) - 1

    def _accessor(self, data, component, kind, count, target, bounds=None):
        self.binary += bytes(-len(self.binary) % 4)
        self.views.append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), "target": target}
        )
        self.binary += data
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": component,
                "count": count,
                "type": kind,
                **(bounds or {}),
            }
        )
        return len(self.accessors) - 1

    def mesh(self, name, material, positions, triangles, normals=None, texcoords=None):
        """An indexed triangle mesh; without normals it is flat. Returns its index."""
        pack = struct.Struct("<3f").pack
        low = [rounded(min(p[i] for p in positions)) for i in range(3)]
        high = [rounded(max(p[i] for p in positions)) for i in range(3)]
        attributes = {
            "POSITION": self._accessor(
                b"".join(pack(*p) for p in positions),
                FLOAT,
                "VEC3",
                len(positions),
                VERTICES,
                {"min": low, "max": high},
            )
        }
        if normals:
            attributes["NORMAL"] = self._accessor(
                b"".join(pack(*n) for n in normals), FLOAT, "VEC3", len(normals), VERTICES
            )
        if texcoords:
            attributes["TEXCOORD_0"] = self._accessor(
                b"".join(struct.pack("<2f", *t) for t in texcoords),
                FLOAT,
                "VEC2",
                len(texcoords),
                VERTICES,
            )
        wide = len(positions) > 65535  # 65535 itself is reserved
        flat = [i for triangle in triangles for i in triangle]
        indices = self._accessor(
            struct.pack("<%d%s" % (len(flat), "I" if wide else "H"), *flat),
            U32 if wide else U16,
            "SCALAR",
            len(flat),
            INDICES,
        )
        self.meshes.append(
            {
                "name": name,
                "primitives": [
                    {"attributes": attributes, "indices": indices, "material": material}
                ],
            }
        )
        return len(self.meshes) - 1

    def image(self, name, rows):
        """An image of rows of (R, G, B) bytes, sRGB; returns its name, by which an emitter asks for
        it."""
        data = png(rows)
        self.binary += bytes(-len(self.binary) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        self.images.append(
            {"name": name, "mimeType": "image/png", "bufferView": len(self.views) - 1}
        )
        return name

    def node(
        self,
        name,
        sensor=None,
        emitter=None,
        surface=None,
        light=None,
        pose=None,
        motion=None,
        **more
    ):
        """A node, with a sensor, an emitter, exact surfaces or a light of KHR_lights_punctual of
        its own, an MCVISI_pose and an MCVISI_motion if given; returns its index."""
        extensions = {"MCVISI_pose": pose} if pose else {}
        if motion:
            extensions["MCVISI_motion"] = motion
        if light:
            extensions["KHR_lights_punctual"] = {"light": len(self.lights)}
            self.lights.append(dict({"name": name}, **light))
        for kind, element in (("sensor", sensor), ("emitter", emitter), ("surface", surface)):
            if element:
                array = self.elements.setdefault(kind, [])
                extensions["MCVISI_%ss" % kind] = {kind: len(array)}
                array.append(dict({"name": name}, **element))
        self.extensions.update(extensions)
        self.nodes.append(
            {"name": name, **more, **({"extensions": extensions} if extensions else {})}
        )
        return len(self.nodes) - 1

    def tree(self, roots):
        """The JSON tree without buffers; roots are the top nodes."""
        extensions = {
            "MCVISI_%ss" % kind: {kind + "s": array} for kind, array in self.elements.items()
        }
        if self.wavelengths:
            extensions["MCVISI_spectrum"] = {"wavelengths": self.wavelengths}
            self.extensions.add("MCVISI_spectrum")
        if self.lights:
            extensions["KHR_lights_punctual"] = {"lights": self.lights}
        tree = {
            "asset": self.asset,
            "scene": 0,
            "scenes": [{"nodes": roots}],
            "extensionsUsed": sorted(self.extensions),
            "extensions": extensions,
            "nodes": self.nodes,
            "materials": self.materials,
            "meshes": self.meshes,
            "images": self.images,
            "textures": self.textures,
            "accessors": self.accessors,
            "bufferViews": self.views,
        }
        return {key: value for key, value in tree.items() if value != [] and value != {}}

    def glb(self):
        """The whole as .glb."""
        self.binary += bytes(-len(self.binary) % 4)
        tree = dict(
            self.tree(list(range(len(self.nodes)))), buffers=[{"byteLength": len(self.binary)}]
        )
        text = dumped(tree).encode()
        text += b" " * (-len(text) % 4)
        return b"".join(
            (
                struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.binary)),
                struct.pack("<I4s", len(text), b"JSON"),
                text,
                struct.pack("<I4s", len(self.binary), b"BIN\0"),
                self.binary,
            )
        )

    def gltf(self):
        """The whole as .gltf with the binary in a data URI: for small scenes, to be read and
        edited."""
        tree = self.tree(list(range(len(self.nodes))))
        if self.binary:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
            tree["buffers"] = [{"byteLength": len(self.binary), "uri": uri}]
        return dumped(tree).encode()


def facing(direction, up=(0, 1, 0)):
    """The glTF rotation (x, y, z, w) that turns a node's -z, along which sensors look and emitters
    shine, into direction."""

    def unit(v):
        length = math.sqrt(sum(c * c for c in v))
        return [c / length for c in v]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    z = unit([-c for c in direction])
    x = unit(cross(up, z))
    y = cross(z, x)
    # Of the four ways to write it take the one with the largest divisor.
    squares = [
        1 + x[0] - y[1] - z[2],
        1 - x[0] + y[1] - z[2],
        1 - x[0] - y[1] + z[2],
        1 + x[0] + y[1] + z[2],
    ]
    largest = squares.index(max(squares))
    rows = [
        [squares[0], x[1] + y[0], z[0] + x[2], y[2] - z[1]],
        [x[1] + y[0], squares[1], y[2] + z[1], z[0] - x[2]],
        [z[0] + x[2], y[2] + z[1], squares[2], x[1] - y[0]],
        [y[2] - z[1], z[0] - x[2], x[1] - y[0], squares[3]],
    ]
    return unit(rows[largest])

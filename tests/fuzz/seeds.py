# SPDX-License-Identifier: Apache-2.0
"""Small files of ours from which the targets of libFuzzer begin. Film files and matrices are written
here a second time, from the descriptions of their formats."""

import io
import json
import re
import struct
import zipfile
import zlib

SETS = (b"sensors/camera/fNumber=8", b"nodes/0/translation=[0,0,1]", b"emitters/0/radiance=2",
        b"materials/0/reflectance=[0.1,0.2,0.3]", b"nodes/0/scale=1e300", b"sensors/0/resolution=4x4")
STL = (b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       b"endloop\nendfacet\nendsolid a\n",
       b"\0" * 80 + b"\1\0\0\0" + b"\0" * 48 + b"\0\0")
TEXTS = (b"\0x,y,z,dx,dy,dz\n0,0,1,0,0,-1\n",
         b"\1MODE SEQ\nUNIT MM\nWAVM 1 0.55 1\nSURF 0\n  CURV 0\n  DISZ INFINITY\nSURF 1\n  STOP\n"
         b"  CURV 0.02\n  DISZ 5\n  GLAS N-BK7\n  DIAM 10\nSURF 2\n  CURV -0.02\n  DISZ 95\nSURF 3\n",
         b"\2LEN NEW\nDIM M\nWL 550\nSO 0 1e10\nS 50 5 BK7\nSTO\nS -50 95\nSI 0 0\nGO\n",
         b"\3%YAML:1.0\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
         b"   rows: 3\n   cols: 3\n   dt: d\n   data: [500,0,320,0,500,240,0,0,1]\n",
         b"\4ParGroup: Cam\n   Camera_type: area_scan_division\n", b'\5{"spp": 4, "set": ["a=1"]}')
TABLES = tuple(bytes([use]) + b"set,size,signal,signal_u,samples,render_error,seconds,message\n" + rows
               for use in range(3)
               for rows in (b"0,1e-5,0.1,0.01,4,0.1,0.5,\n1,2e-5,3,0.01,4,0.1,0.5,\n",
                            b'3,,,,,,,"a ""b"", c"\n4,1,2,,4,inf,1,device trouble: lost\n5,1'))
EDGE = {"edge": "edge=12,4,72,56", "metric": ["edge.width_10_90", "f:=2*edge.position"], "spp": 4}
STOP = "sensors/camera/stopDiameter"
EXPERIMENTS = tuple(
    bytes([verb]) + json.dumps({**EDGE, **more}).encode()
    for verb, more in (
        (0, {"vary": [STOP + "=1mm..8mm:3:log", "nodes/0/translation/2=0,0.1mm"],
             "tie": ["sensors/camera/imageDistance=50mm+stopDiameter"], "where": ["stopDiameter>2e-3"], "design": "sobol",
             "points": 8, "best": "f=smallest", "until": ["f=0.1"], "range": "0/2"}),
        (1, {"tolerance": [STOP + "=normal(0.1mm)", "nodes/0/translation/2=uniform(1mm)"],
             "correlate": ["stopDiameter,_2=0.5"], "trials": 10}),
        (2, {"vary": [STOP + "=1mm..8mm"], "objective": ["edge.width_10_90=smallest"],
             "better": ["edge.width_10_90=0.1"], "where": ["stopDiameter<6e-3"]})))
# Options of calls of the C interface, in the order of fuzz_api.c.
RADIANCE = "emitters/back/radiance"
CALLS = (
    {"device": "reference", "threads": 2, "precision": "double"},
    {"spp": 4, "seed": 3, "sampler": "random", "depth": 4, "replicates": 2, "error": 0.5},
    {"spp": 4, "output": "x.exr", "camera": "y.png", "expose_to": 0.5, "json": False},
    {"vary": [RADIANCE + "=1..2:2"], "metric": "m:=a.mean", "region": "a=0,0,4,4", "spp": 4,
     "output": "t.csv", "force": True, "design": "lhs", "points": 3},
    {"tolerance": RADIANCE + "=normal(0.1)", "metric": "mean", "spp": 4, "trials": 0,
     "output": "u.csv", "force": True},
    {"vary": RADIANCE + "=1..2", "metric": "m:=mean", "objective": "m=largest", "evaluations": 40,
     "spp": 4, "output": "o.csv", "force": True},
    {"vary": RADIANCE + "=1..2:2", "metric": "m:=mean", "spp": 4, "output": "p.csv", "force": True,
     "pod": {"signal": "m", "size": "radiance", "threshold": 1, "output": "p.html"}},
    {"threshold": "2", "size-unit": "none", "confidence": 0.9},
    {"html": "c.html", "json": False},
    {"pixel": "3,2", "spp": 16},
    {"depth": 4},
    {"spp": 4, "keep": 0.9},
    {"edge": "e=0,0,24,16", "line": "0,0,12,16+12,0,12,16", "circle": "c=2,0,16,16", "noise": 0.1},
    {"expose_to": 0.5, "wavelength": [5e-7, 5.5e-7, 6e-7], "bits": 8, "bayer": "RGGB"},
    {"output": "d.png", "json": True},
    {"electrons_per_unit": 1000, "output": "v.png"},
    {"angular": "2x2", "output": "v.png"},
    {"form": "mass", "threads": 1, "angular": "2x2"},
    {"preview": True, "parts": ["image"]},
    {"a": "text", "b": 1.5, "c": [1, 2]},
    {"asset": {"version": "2.0"}, "scenes": [], "nodes": [{"name": "a"}]},
    {"unit": "mm", "light": "backlight"},
    {"format": "opencv", "sensor": "camera"},
    [8, "6mm"],
    {"node": "plate", "at": "0mm,0mm,0mm", "size": "1mm", "depth": "1um"},
    {"plane": "plate", "spp": 4, "unwrap": "gray", "noise": 1, "remove_form": "plane", "screen": "back"},
    {"fit": "contrast", "region": "0,0,4,4", "background": "4,0,4,4", "json": True},
    {"json": True},
    {"method": "least-squares", "field": "bright", "emitter": "projector", "bits": 8,
     "damping": 0.1, "json": True},
    {"sequence": 'projector={"type": "phaseShift", "steps": 4, "periods": 16}'},
    {"laser": "back", "output": ["t.exr"], "json": True})


def calls():
    return [bytes([call]) + json.dumps(options).encode() for call, options in enumerate(CALLS)]


def experiments(root):
    """The shipped ones, which are of scenes of their own."""
    for path in sorted(root.glob("scenes/*.json")):
        experiment = json.loads(path.read_text())
        del experiment["rig"]
        yield b"\0" + json.dumps(experiment).encode()


def film(sizes, facts, values):
    """A film file (host/film/film_file.h)."""
    text = json.dumps({"film": sizes, **facts}).encode()
    data = b"MCVFILM1" + struct.pack("<Q", len(text)) + text + bytes(-len(text) % 8) + values
    return data + struct.pack("<Q", zlib.crc32(data))


def films(root):
    """A part, a part with light paths, and checkpoints."""
    version = re.search(r"VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text()).group(1)
    sizes = {"width": 2, "height": 1, "channels": 1, "replicates": 1, "samples": 4, "splats": False,
             "splat_value": 0.0, "levels": False}
    facts = {"version": version, "identity": {}, "device": {"name": "d"}, "stats": {"paths": 8}}
    part = {**facts, "range": [0, 4], "attributes": {"exposure": 1.5, "text": "a", "list": [1, 2]}}
    state = {**facts, "state": {"thinning": 0, "decided": True, "seconds": 1.5}}
    sums = struct.pack("<2d", 1, 2)
    round_of = {"first": 4, "count": 4, "class": 0, "sets": 1, "begun": True}
    return (film(sizes, part, sums),
            film({**sizes, "splats": True, "splat_value": 0.5}, part, 2 * sums),
            film({**sizes, "round": {**round_of, "begun": False}}, state, sums),
            film({**sizes, "splats": True, "levels": True, "round": round_of}, state,
                 2 * sums + bytes(8) + 2 * sums))


def array(dtype, shape, values, code):
    """An NPY array."""
    head = "{'descr': '%s', 'fortran_order': False, 'shape': %s, }" % (dtype, shape)
    head += " " * (-(len(head) + 11) % 64) + "\n"
    return (b"\x93NUMPY\x01\0" + struct.pack("<H", len(head)) + head.encode() +
            struct.pack("<%d%s" % (len(values), code), *values))


def matrices():
    """A matrix of 2 x 1 pixels, a lamp and a projector of 2 x 1 pixels; and a thinned one."""
    for residual in (False, True):
        groups = [{"emitter": name, "type": "area", "first": first, "width": width, "height": 1,
                   "radiance": [1, 1, 1], "to_world": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}
                  for name, first, width in (("a", 0, 1), ("b", 1, 2))]
        header = {"format": "mcvisi transport", "version": 1, "width": 2, "height": 1,
                  "channels": 1, "replicates": 2, "samples": 4, "kept": 0.9 if residual else 1,
                  "residual": residual, "elements": groups, "attributes": {"a": 1}}
        file = io.BytesIO()
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("header.json", json.dumps(header))
            archive.writestr("format.npy", array("|S3", "()", (), "B") + b"csr")
            archive.writestr("shape.npy", array("<i8", "(2,)", (2, 3 + residual), "q"))
            archive.writestr("indptr.npy", array("<i8", "(3,)", (0, 2, 3), "q"))
            archive.writestr("indices.npy", array("<i4", "(3,)", (0, 2, 1), "i"))
            archive.writestr("data.npy", array("<f8", "(3,)", (1, 2, 3), "d"))
            archive.writestr("replicates.npy", array("<f4", "(3,2)", (1, 1, 2, 2, 3, 3), "f"))
            archive.writestr("pattern.npy", array("<f4", "(3,1)", (1, 0.5, 1), "f"))
        yield file.getvalue()

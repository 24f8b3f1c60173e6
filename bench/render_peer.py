# SPDX-License-Identifier: Apache-2.0
"""render_peer.py VARIANT [MESH.ply FOLDER SEED]: Mitsuba 3 for bench_render, which writes lines `PIXELS INTEGRATOR SAMPLER SAMPLES SEED SCENE` to its
standard input and reads each image as doubles, [channel][row][column]. A scene is loaded once for each size, integrator and
sampler. mesh_scenes.py has written its scenes of that seed to FOLDER by the time they are asked for."""

import functools
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests" / "peers"))

import mesh_scenes
import mitsuba_peer  # sets the variant
import mitsuba as mi
import numpy

FORMAT = "luminance" if "mono" in mi.variant() else "rgb"
SCENES = mitsuba_peer.cases(coloured=True, mesh=sys.argv[2] if len(sys.argv) > 2 else None)


@functools.cache
def load(name, pixels, integrator, sampler):
    # As many surfaces as bench_render allows, and Russian roulette as Mitsuba does it unless told
    # otherwise.
    if name in mesh_scenes.SCENES:
        scene, sensor, depth = mesh_scenes.case(sys.argv[3], name, int(sys.argv[4]))
        sensor |= mitsuba_peer.sensor_base(pixels, 16, sampler, FORMAT)
    else:
        scene, sensor, depth = dict(SCENES[name]), mitsuba_peer.sensor(name, pixels, 16, sampler, FORMAT), 32
    return mi.load_dict(scene | {"type": "scene", "sensor": sensor, "integrator": {"type": integrator, "max_depth": depth}})


def main():
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what Mitsuba says is no image
    mi.set_log_level(mi.LogLevel.Error)
    for line in sys.stdin:
        pixels, integrator, sampler, samples, seed, name = line.strip().split(" ", 5)
        image = mi.render(
            load(name, int(pixels), integrator, sampler), seed=int(seed), spp=int(samples)
        )
        out.write(
            numpy.ascontiguousarray(
                numpy.array(image, dtype=numpy.float64).transpose(2, 0, 1)
            ).tobytes()
        )
        out.flush()


if __name__ == "__main__":
    main()

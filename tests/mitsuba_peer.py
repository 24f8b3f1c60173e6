# SPDX-License-Identifier: Apache-2.0
"""mitsuba_peer.py CASE PIXELS REPLICATES SAMPLES: renders one of the scenes of test_mitsuba_peer.c with Mitsuba 3 and writes the replicates'
images to standard output as doubles, row by row."""

import sys

import mitsuba as mi
import numpy

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f


def rectangle(width, height, to_world, **more):
    """In the xy plane, its front towards +z."""
    return {"type": "rectangle", "to_world": to_world @ T().scale([width / 2, height / 2, 1]), **more}


def up(x, y, z):
    return T().translate([x, y, z])


def down(x, y, z):
    return T().translate([x, y, z]) @ T().rotate([1, 0, 0], 180)


def diffuse(share):
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": share}}


def light(radiance):
    return {"type": "area", "radiance": {"type": "rgb", "value": radiance}}


def sky(radiance):
    return {"type": "constant", "radiance": {"type": "rgb", "value": radiance}}


GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
BLACK = diffuse(0.0)
FLOOR = rectangle(4, 4, up(0, 0, 0), bsdf=diffuse(0.6))
LAMP = rectangle(1, 1, down(0.8, 0.3, 2), bsdf=BLACK, emitter=light(3.0))


def ball(radius, z, bsdf, **more):
    return {"type": "sphere", "radius": radius, "center": [0, 0, z], "bsdf": bsdf, **more}


CASES = {
    "furnace": {"sky": sky(1.0), "ball": ball(0.5, 1, GLASS)},
    "sky": {"sky": sky(1.0), "ball": ball(0.5, 1, diffuse(0.5)), "floor": FLOOR},
    "area": {"lamp": LAMP, "floor": FLOOR, "ball": ball(0.3, 0.3, diffuse(0.8))},
    "lens": {"lamp": LAMP, "floor": FLOOR, "sky": sky(0.2), "ball": ball(0.3, 1.5, GLASS)},
    "conductor": {"lamp": LAMP, "floor": FLOOR, "sky": sky(0.2), "ball": ball(0.4, 0.4, {"type": "conductor", "eta": 0.27, "k": 3.61})},
    "rough conductor": {
        "lamp": LAMP,
        "floor": FLOOR,
        "sky": sky(0.2),
        "ball": ball(0.4, 0.4, {"type": "roughconductor", "distribution": "ggx", "alpha": 0.05, "eta": 0.27, "k": 3.61}),
    },
    "telecentric": {"lamp": LAMP, "floor": FLOOR, "ball": ball(0.3, 0.5, diffuse(0.8))},
    "absorbing": {
        "sky": sky(1.0),
        "floor": FLOOR,
        "ball": ball(0.4, 1, GLASS, interior={"type": "homogeneous", "albedo": 0.0, "sigma_t": 2.0}),
    },
    "cube": {
        "sky": sky(0.5),
        "floor": FLOOR,
        "cube": {"type": "cube", "to_world": T().translate([0.1, 0, 0.8]) @ T().rotate([0, 0, 1], 30) @ T().scale([0.3, 0.4, 0.2]), "bsdf": GLASS},
    },
}


def sensor(case, pixels, samples):
    film = {"type": "hdrfilm", "width": pixels, "height": pixels, "pixel_format": "luminance", "component_format": "float32"}
    film["rfilter"] = {"type": "box"}
    common = {"film": film, "sampler": {"type": "independent", "sample_count": samples}}
    look = T().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])
    fov = 2 * numpy.degrees(numpy.arctan(0.25))  # half a metre per metre of distance
    if case == "lens":
        return {"type": "thinlens", "to_world": look, "fov": fov, "aperture_radius": 0.05, "focus_distance": 4.0, **common}
    if case == "telecentric":
        return {"type": "orthographic", "to_world": look @ T().scale([0.5, 0.5, 1]), **common}
    return {"type": "perspective", "to_world": look, "fov": fov, **common}


def main(case, pixels, replicates, samples):
    scene = dict(CASES[case], type="scene", sensor=sensor(case, pixels, samples))
    kind = "volpath" if case == "absorbing" else "path"
    scene["integrator"] = {"type": kind, "max_depth": 64, "rr_depth": 1000}
    loaded = mi.load_dict(scene)
    for replicate in range(replicates):
        image = numpy.array(mi.render(loaded, seed=replicate + 1, spp=samples), dtype=numpy.float64)
        sys.stdout.buffer.write(numpy.ascontiguousarray(image[..., 0]).tobytes())


if __name__ == "__main__":
    main(sys.argv[1], *(int(a) for a in sys.argv[2:]))

# SPDX-License-Identifier: Apache-2.0
"""
mitsuba_peer.py CASE PIXELS REPLICATES SAMPLES

Renders one of the scenes of peer_scenes.h with Mitsuba 3 and writes the replicates' images to
standard output as doubles, row by row. bench/render_peer.py uses these scenes too; its first
argument is the variant of Mitsuba.
"""

import glob
import os
import sys

# Dr.Jit wants a young LLVM; Debian's libllvm19 is in no place where it looks.
found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*"))
if found:
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", found[0])

import drjit as dr
import mitsuba as mi
import numpy

# Its light is a plugin in Python, which a scalar variant would call for each ray.
PANEL = "parallel panel"
mi.set_variant(
    sys.argv[1]
    if sys.argv[1] in mi.variants()
    else "llvm_ad_rgb" if sys.argv[1] == PANEL else "scalar_rgb"
)
T = mi.ScalarTransform4f


class Parallel(mi.Emitter):
    """The report's parallel emitter (4.1.1): the points of a shape emit the radiance within an
    angle about the normal, and nothing else. It is sampled as Mitsuba samples its area lights:
    from a receiver by the shape, for light paths by point and cone.
    """

    def __init__(self, properties):
        super().__init__(properties)
        self.radiance = mi.Color3f(properties["radiance"])
        self.sine = float(
            numpy.sin(properties["half_angle"])
        )  # in single precision a cosine is off by a thousandth of the cone
        self.m_flags = mi.EmitterFlags.Surface

    def seen(self, away, normal, active):
        within = (dr.dot(away, normal) > 0) & (
            dr.squared_norm(dr.cross(away, normal)) <= self.sine**2
        )
        return dr.select(active & within, self.radiance, 0)

    def eval(self, si, active=True):
        return self.seen(si.wi, mi.Normal3f(0, 0, 1), active)

    def sample_direction(self, it, sample, active=True):
        ds = self.get_shape().sample_direction(it, sample, active)
        ds.emitter = mi.EmitterPtr(self)
        return ds, dr.select(ds.pdf > 0, self.eval_direction(it, ds, active) / ds.pdf, 0)

    def pdf_direction(self, it, ds, active=True):
        return dr.select(dr.dot(ds.d, ds.n) < 0, self.get_shape().pdf_direction(it, ds, active), 0)

    def eval_direction(self, it, ds, active=True):
        return self.seen(-ds.d, ds.n, active)

    def sample_position(self, time, sample, active=True):
        ps = self.get_shape().sample_position(time, sample, active)
        return ps, dr.select(active & (ps.pdf > 0), dr.rcp(ps.pdf), 0)

    def sample_wavelengths(self, si, sample, active=True):
        return si.wavelengths, self.radiance

    def sample_ray(self, time, sample1, sample2, sample3, active=True):
        ps, area = self.sample_position(time, sample2, active)
        si = mi.SurfaceInteraction3f(ps, dr.zeros(mi.Color0f))
        across = mi.warp.square_to_uniform_disk_concentric(sample3) * self.sine
        local = mi.Vector3f(across.x, across.y, dr.sqrt(1 - dr.squared_norm(across)))
        flux = area * float(numpy.pi) * self.sine**2  # uniform by projected solid angle
        return si.spawn_ray(si.to_world(local)), self.radiance * flux

    def bbox(self):
        return self.get_shape().bbox()


if not mi.variant().startswith("scalar"):
    mi.register_emitter("parallel", Parallel)


def rectangle(width, height, to_world, **more):
    """In the xy plane, its front towards +z."""
    return {
        "type": "rectangle",
        "to_world": to_world @ T().scale([width / 2, height / 2, 1]),
        **more,
    }


def up(x, y, z):
    return T().translate([x, y, z])


def down(x, y, z):
    return T().translate([x, y, z]) @ T().rotate([1, 0, 0], 180)


def rgb(value):
    return {"type": "rgb", "value": value}


def light(radiance):
    return {"type": "area", "radiance": rgb(radiance)}


def sky(radiance):
    return {"type": "constant", "radiance": rgb(radiance)}


GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}
METAL = {"eta": 0.27, "k": 3.61}
BLACK = {"type": "diffuse", "reflectance": rgb(0.0)}
LAMP = rectangle(1, 1, down(0.8, 0.3, 2), bsdf=BLACK, emitter=light(3.0))
TINT = (1.0, 5 / 6, 2 / 3)


def ball(radius, z, bsdf, **more):
    return {"type": "sphere", "radius": radius, "center": [0, 0, z], "bsdf": bsdf, **more}


def block(bsdf):
    return {
        "type": "cube",
        "to_world": T().translate([0.1, 0, 0.8])
        @ T().rotate([0, 0, 1], 30)
        @ T().scale([0.3, 0.4, 0.2]),
        "bsdf": bsdf,
    }


def panel():
    """100 x 100 mm, 100 mm from the origin, 30° above the floor."""
    at = T().look_at(origin=[0.1 * 0.75**0.5, 0, 0.05], target=[0, 0, 0], up=[0, 1, 0])
    return rectangle(
        0.1,
        0.1,
        at,
        bsdf=BLACK,
        emitter={"type": "parallel", "radiance": rgb(1e4), "half_angle": numpy.radians(0.5)},
    )


def opening():
    """
    Parallel light of half a degree about its axis: an opening in a black wall, and far behind it a
    disc. From 10 km the beam would widen by a thousandth up to the floor, which the image's mean
    would show.
    """
    far, half_angle = 1e5, numpy.radians(0.5)
    wall = T().look_at(origin=[8 / 5**0.5, 0, 4 / 5**0.5], target=[0, 0, 0], up=[0, 1, 0])
    sides = [
        (-3.25, 0, 6, 12.5),
        (3.25, 0, 6, 12.5),
        (0, -3.25, 0.5, 6),
        (0, 3.25, 0.5, 6),
    ]  # round 0.5 x 0.5
    parts = {
        f"wall {i}": rectangle(w, h, wall @ up(x, y, 0), bsdf=BLACK)
        for i, (x, y, w, h) in enumerate(sides)
    }
    disc = {
        "type": "disk",
        "to_world": wall @ up(0, 0, -far) @ T().scale([far * numpy.tan(half_angle)] * 3),
        "bsdf": BLACK,
        "emitter": light(1e4),
    }
    return {**parts, "disc": disc}


def cases(coloured=False, mesh=None):
    def diffuse(share):
        return {
            "type": "diffuse",
            "reflectance": rgb([share * t for t in TINT] if coloured else share),
        }

    floor = rectangle(4, 4, up(0, 0, 0), bsdf=diffuse(0.6))
    lit = {"lamp": LAMP, "floor": floor}
    made = {
        "furnace": {"sky": sky(1.0), "ball": ball(0.5, 1, GLASS)},
        "sky": {"sky": sky(1.0), "ball": ball(0.5, 1, diffuse(0.5)), "floor": floor},
        "area": {**lit, "ball": ball(0.3, 0.3, diffuse(0.8))},
        "lens": {**lit, "sky": sky(0.2), "ball": ball(0.3, 1.5, GLASS)},
        "conductor": {
            **lit,
            "sky": sky(0.2),
            "ball": ball(0.4, 0.4, {"type": "conductor", **METAL}),
        },
        "rough conductor": {
            **lit,
            "sky": sky(0.2),
            "ball": ball(
                0.4, 0.4, {"type": "roughconductor", "distribution": "ggx", "alpha": 0.05, **METAL}
            ),
        },
        "satin conductor": {
            **lit,
            "sky": sky(0.2),
            "ball": ball(
                0.4, 0.4, {"type": "roughconductor", "distribution": "ggx", "alpha": 0.02, **METAL}
            ),
        },
        "rough glass": {
            **lit,
            "sky": sky(0.2),
            "ball": ball(
                0.4,
                0.6,
                {
                    "type": "roughdielectric",
                    "distribution": "ggx",
                    "alpha": 0.02,
                    "int_ior": 1.5,
                    "ext_ior": 1.0,
                },
            ),
        },
        "telecentric": {**lit, "ball": ball(0.3, 0.5, diffuse(0.8))},
        "telecentric backlight": {
            "lamp": LAMP,
            "backlight": rectangle(3, 3, up(0, 0, 0), bsdf=BLACK, emitter=light(1.0)),
            "block": block(diffuse(0.5)),
        },
        "absorbing": {
            "sky": sky(1.0),
            "floor": floor,
            "ball": ball(
                0.4, 1, GLASS, interior={"type": "homogeneous", "albedo": 0.0, "sigma_t": 2.0}
            ),
        },
        "cube": {"sky": sky(0.5), "floor": floor, "cube": block(GLASS)},
        "opening": {**opening(), "floor": floor, "ball": ball(0.2, 0.2, diffuse(0.8))},
        PANEL: {"panel": panel(), "floor": floor, "ball": ball(0.02, 0.02, diffuse(0.8))},
    }
    if mesh:
        place = T().translate([0, 0, 0.8]) @ T().scale([0.7] * 3)
        twosided = {"type": "twosided", "bsdf": diffuse(0.5)}
        made["assembly"] = {
            **lit,
            "mesh": {
                "type": "ply",
                "filename": mesh,
                "face_normals": True,
                "to_world": place,
                "bsdf": twosided,
            },
        }
    return made


def sensor_base(pixels, samples, sampler, pixel_format):
    film = {
        "type": "hdrfilm",
        "width": pixels,
        "height": pixels,
        "pixel_format": pixel_format,
        "component_format": "float32",
    }
    film["rfilter"] = {"type": "box"}
    return {"film": film, "sampler": {"type": sampler, "sample_count": samples}}


def sensor(case, pixels, samples, sampler="independent", pixel_format="luminance"):
    common = sensor_base(pixels, samples, sampler, pixel_format)
    look = T().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])
    fov = 2 * numpy.degrees(numpy.arctan(0.25))  # half a metre per metre of distance
    if case == "lens":
        return {
            "type": "thinlens",
            "to_world": look,
            "fov": fov,
            "aperture_radius": 0.05,
            "focus_distance": 4.0,
            **common,
        }
    if case.startswith("telecentric"):
        return {"type": "orthographic", "to_world": look @ T().scale([0.5, 0.5, 1]), **common}
    if case == PANEL:
        look, fov = T().look_at(
            origin=[0, 0, 0.4], target=[0, 0, 0], up=[0, 1, 0]
        ), 2 * numpy.degrees(numpy.arctan(0.125))
    return {"type": "perspective", "to_world": look, "fov": fov, **common}


def main(case, pixels, replicates, samples):
    scene = dict(cases()[case], type="scene", sensor=sensor(case, pixels, samples))
    kind = {"absorbing": "volpath", PANEL: "ptracer"}.get(
        case, "path"
    )  # path hardly ever meets the panel's cone
    scene["integrator"] = {"type": kind, "max_depth": 64, "rr_depth": 1000}
    loaded = mi.load_dict(scene)
    for replicate in range(replicates):
        image = numpy.array(mi.render(loaded, seed=replicate + 1, spp=samples), dtype=numpy.float64)
        sys.stdout.buffer.write(numpy.ascontiguousarray(image[..., 0]).tobytes())


if __name__ == "__main__":
    main(sys.argv[1], *(int(a) for a in sys.argv[2:]))

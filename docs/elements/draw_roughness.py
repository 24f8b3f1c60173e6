# SPDX-License-Identifier: Apache-2.0
"""Rough materials: the profile of microfacets, and the lobes that GGX gives for three
roughnesses."""

import math

from sketch import DIM, EDGE, FAINT, GLASS, HUES, INK, LIGHT, PALE, SIGHT, Sketch, polar

BACK = HUES[3]


def ggx_lobe(alpha, angle):
    """What microfacets of this α reflect once, times the cosine, in the plane of incidence: D G/(4
    cos θ) with Smith's height-correlated G, for perfectly reflecting facets. Angles in degrees from
    the normal, positive towards the mirror direction."""
    i = math.radians(-angle)

    def smith(a):
        return (math.sqrt(1 + (alpha * math.tan(a)) ** 2) - 1) / 2

    def value(out):
        o = math.radians(out)
        if abs(out) > 89:
            return 0
        h = (i + o) / 2
        d = alpha**2 / (math.pi * (math.cos(h) ** 2 * (alpha**2 - 1) + 1) ** 2)
        return d / (1 + smith(i) + smith(o)) / (4 * math.cos(i))

    return value


def scaled(lobe):
    """The same with 1 as its largest value."""
    top = max(lobe(k / 4) for k in range(-359, 360))
    return lambda angle: lobe(-angle) / top  # a Sketch turns counter-clockwise


def roughness():
    s = Sketch(780, 270, (135, 80), "Microfacets: a rough surface is made of small mirrors")
    heights = (0, 13, 5, 22, 9, 16, 2, 19, 10, 14, 4)
    profile = [(-110 + 22 * k, h) for k, h in enumerate(heights)]
    s.area(profile + [(110, -18), (-110, -18)], "#dddddd", INK)
    facet = ((profile[4][0] + profile[5][0]) / 2, (heights[4] + heights[5]) / 2)
    tilt = math.degrees(math.atan2(heights[5] - heights[4], 22))
    h = 90 + tilt
    s.arrow(facet, polar(facet, 105, h), DIM, 1.2)
    s.text(polar(facet, 116, h + 2), "h", "middle", DIM)
    s.line([facet, (facet[0], 150)], FAINT, 1, "5 4")
    s.text((facet[0] + 8, 152), "n", "middle", FAINT)
    s.ray([polar(facet, 140, h + 38), facet], SIGHT, 1.5)
    s.ray([facet, polar(facet, 140, h - 38)], LIGHT, 1.5)
    s.text((0, -36), "h: normal of a microfacet")
    s.text((0, -54), "n: normal of the surface")
    at = (335, 0)
    s.wall((at[0] - 150, 0), (at[0] + 112, 0))
    s.ray([polar(at, 170, 90 + 40), at], SIGHT, 1.6)
    for value, colour, length in ((0.6, HUES[3], 62), (0.4, HUES[2], 108), (0.25, HUES[1], 165)):
        s.lobe(at, 90, length, scaled(ggx_lobe(value**2, 40)), "none", colour)
        s.text(
            (at[0] + 122, 36 + (length - 62) * 0.95),
            "`roughness` %g: α = %.3g" % (value, value**2),
            "start",
            colour,
            12,
        )
    s.line([at, (at[0], 160)], FAINT, 1, "5 4")
    s.text((at[0] - 10, -36), "the lobes are not to one scale")
    return s


def conductor():
    s = Sketch(
        720,
        270,
        (210, 70),
        "Conductor: a metal reflects by Fresnel's formulas, rough or " "brushed",
    )
    s.wall((-160, 0), (160, 0))
    s.lobe((0, 0), 90, 150, scaled(ggx_lobe(0.09, 45)))
    s.line([(0, 0), (0, 150)], FAINT, 1, "5 4")
    s.ray([polar((0, 0), 165, 135), (0, 0)], SIGHT, 1.6)
    s.text(polar((0, 0), 172, 135), "light", "end", SIGHT)
    s.angle((0, 0), 46, 90, 135, "θ")
    s.text((92, 150), "F(θ) of `n` - i `k`,", "middle", LIGHT)
    s.text((92, 133), "or of a `metal`", "middle", LIGHT)
    s.text((118, 30), "`roughness`", "start", LIGHT)
    s.text((0, -28), "opaque: what is not reflected is absorbed", "middle", DIM)
    x, y = 370, 92
    s.area([(x - 75, y - 75), (x + 75, y - 75), (x + 75, y + 75), (x - 75, y + 75)], "#eeeeee", INK)
    for k in range(-6, 7):
        s.line([(x + 10 * k, y - 70), (x + 10 * k, y + 70)], FAINT, 0.7)
    oval = [
        (x + 60 * math.cos(math.radians(3 * a)), y + 18 * math.sin(math.radians(3 * a)))
        for a in range(120)
    ]
    s.area(oval, PALE, LIGHT, 0.8)
    s.arrow((x, y), (x + 92, y), EDGE, 1.6)
    s.text((x + 90, y + 14), "tangent", "middle", EDGE)
    s.text((x, y - 50), "grooves", "middle", DIM)
    s.text((x, y - 92), "`anisotropy`: a highlight as wide", "middle", INK)
    s.text((x, y - 109), "as α_t along the tangent", "middle", INK)
    return s


def metallic_roughness():
    s = Sketch(
        640,
        300,
        (240, 150),
        "Metallic-roughness: a gloss above a diffuse base, thin " "transmission below",
    )
    s.area([(-180, 0), (180, 0), (180, -16), (-180, -16)], "#f3e3e1", INK)
    s.area([(-180, 4), (180, 4), (180, 0), (-180, 0)], GLASS, EDGE, width=0.8)
    s.lobe((0, 4), 90, 62, lambda a: math.cos(math.radians(a)), "#f6d9d6", SIGHT)
    s.lobe((0, 4), 90, 140, scaled(ggx_lobe(0.06, 45)))
    s.lobe((0, -16), -90, 44, lambda a: math.cos(math.radians(a)), "#d5e2f6", BACK)
    passed = scaled(ggx_lobe(0.06, 45))
    s.lobe((0, -16), -90, 100, lambda a: passed(-a), "#d7ecdf", HUES[2])
    s.line([(0, -120), (0, 135)], FAINT, 1, "5 4")
    s.ray([polar((0, 4), 160, 135), (0, 4)], SIGHT, 1.6)
    s.text(polar((0, 4), 168, 135), "light", "end", SIGHT)
    s.text((108, 98), "gloss: F0 from `ior`, or from", "start", LIGHT)
    s.text((108, 81), "`baseColor` where `metallic`", "start", LIGHT)
    s.text((74, 34), "diffuse in `baseColor`", "start", SIGHT)
    s.text((78, -84), "`transmission`, spread by `roughness`", "start", HUES[2])
    s.text((-26, -62), "`diffuseTransmission`", "end", BACK)
    return s


DRAWINGS = {
    "roughness": roughness,
    "conductor": conductor,
    "metallic-roughness": metallic_roughness,
}

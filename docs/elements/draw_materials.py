# SPDX-License-Identifier: Apache-2.0
"""Materials: light comes from the upper left; what a lobe shows is worked out by its formula."""

import math

from sketch import DIM, EDGE, FAINT, GLASS, HUES, INK, LIGHT, SIGHT, Sketch, polar

BACK = HUES[3]  # light that passes


def cosine(angle):
    return math.cos(math.radians(angle))


def incident(s, angle, length=130, words="", at=(0, 0)):
    """A ray that comes in at this angle to the upward normal, from the left."""
    s.ray([polar(at, length, 90 + angle), at], SIGHT, 1.6)
    if words:
        s.text(polar(at, length + 12, 90 + angle), words, "end", SIGHT)


def normal(s, up, down=0, at=(0, 0)):
    s.line([(at[0], at[1] - down), (at[0], at[1] + up)], FAINT, 1, "5 4")


def diffuse():
    s = Sketch(560, 270, (250, 140), "Diffuse material: a cosine lobe on the side of the light, a "
               "smaller one on the other side")
    s.lobe((0, 0), 90, 92, cosine)
    s.lobe((0, 0), -90, 52, cosine, "#d5e2f6", BACK)
    s.area([(-170, 2), (170, 2), (170, -4), (-170, -4)], "#dddddd", INK)
    normal(s, 112)
    incident(s, 55, 150, "light")
    s.text((66, 78), "`reflectance`: f = ρ/π", "start", LIGHT)
    s.text((48, -44), "`transmittance`: f = τ/π", "start", BACK)
    s.text((-170, -22), "thin: paper, opal", "start", DIM)
    return s


def absorber():
    s = Sketch(420, 180, (200, 45), "Absorber: nothing leaves it")
    s.area([(-140, 0), (140, 0), (140, -12), (-140, -12)], INK)
    incident(s, 40, 115, "light")
    normal(s, 90)
    s.text((24, 24), "nothing leaves", "start", DIM)
    return s


def mirror():
    s = Sketch(520, 220, (230, 55), "Mirror: a share of the light is reflected, at any angle")
    s.wall((-160, 0), (160, 0))
    normal(s, 130)
    incident(s, 48, 140, "light")
    s.ray([(0, 0), polar((0, 0), 140, 42)], LIGHT, 1.6)
    s.angle((0, 0), 50, 90, 138, "θ")
    s.angle((0, 0), 50, 42, 90, "θ")
    s.text(polar((0, 0), 150, 42), "`reflectance`", "start", LIGHT)
    return s


def beam_splitter():
    s = Sketch(560, 260, (230, 125), "Beam splitter: one share is reflected, one passes straight")
    s.line([polar((0, 0), 105, 45), polar((0, 0), -105, 45)], EDGE, 3)
    s.ray([(-170, 0), (0, 0)], SIGHT, 1.8)
    s.ray([(0, 0), (150, 0)], BACK, 1.6)
    s.ray([(0, 0), (0, 100)], LIGHT, 1.6)
    s.text((-174, 0), "light", "end", SIGHT)
    s.text((156, 0), "× `transmittance`", "start", BACK)
    s.text((0, 112), "× `reflectance`", "middle", LIGHT)
    s.text((80, -74), "the rest is absorbed", "start", DIM)
    return s


def sheet():
    s = Sketch(620, 270, (250, 135), "Sheet: all reflections between its two interfaces at once")
    s.area([(-190, 3), (190, 3), (190, -3), (-190, -3)], GLASS, EDGE)
    normal(s, 105, 105)
    incident(s, 50, 140, "light")
    s.ray([(0, 0), polar((0, 0), 140, 40)], LIGHT, 1.6)
    s.ray([(0, 0), polar((0, 0), 140, -40)], BACK, 1.6)
    s.text(polar((0, 0), 148, 40), "R' = 2 R / (1 + R)", "start", LIGHT)
    s.text(polar((0, 0), 148, -40), "(1 - R') × `transmittance`", "start", BACK)
    s.text((-190, -22), "`ior` n, no thickness", "start", EDGE)
    s.text((24, -86), "no offset", "middle", DIM)
    return s


def dielectric():
    s = Sketch(680, 330, (230, 175), "Dielectric: reflection and refraction at the surface, "
               "absorption inside, a bubble of higher priority")
    n, angle = 1.5, 50
    inside = math.degrees(math.asin(math.sin(math.radians(angle)) / n))
    s.area([(-190, 0), (380, 0), (380, -130), (-190, -130)], GLASS, EDGE)
    normal(s, 110, 110)
    incident(s, angle, 140, "light")
    s.ray([(0, 0), polar((0, 0), 140, 90 - angle)], LIGHT, 1.6)
    depth = 130 / math.cos(math.radians(inside))
    low = polar((0, 0), depth, -90 + inside)
    s.ray([(0, 0), low], BACK, 1.6)
    s.line([low, polar(low, 24, -90 + angle)], BACK, 1.6)
    s.angle((0, 0), 52, 90, 90 + angle, "θ")
    s.angle((0, 0), 62, -90, -90 + inside, "θ'", 12)
    s.text(polar((0, 0), 148, 90 - angle), "F, or R with a `coating`", "start", LIGHT)
    s.text((low[0] - 8, -112), "d", "end", BACK)
    s.text((86, -76), "(1 - F) exp(-σ d)", "start", BACK)
    s.text((-182, -24), "`ior` n or `glass`,", "start", EDGE)
    s.text((-182, -41), "`priority` 0", "start", EDGE)
    s.text((-182, -58), "σ: `absorption`", "start", EDGE)
    s.circle((290, -58), 44, "#ffffff", EDGE)
    s.text((290, -50), "`ior` 1")
    s.text((290, -68), "`priority` 1")
    s.text((290, 14), "bubble: the larger priority fills the space", "middle", DIM)
    return s


def coating():
    """Reflectance over the angle of incidence, bare and coated, for n = 1.5."""
    s = Sketch(560, 320, (80, 60), "Reflectance of glass of n = 1.5, bare and with a coating of "
               "0.5 percent")
    n, residual, wide, tall = 1.5, 0.005, 380, 220

    def bare(angle):
        c = math.cos(math.radians(angle))
        t = math.sqrt(1 - (1 - c * c) / n ** 2)
        return (((c - n * t) / (c + n * t)) ** 2 + ((n * c - t) / (n * c + t)) ** 2) / 2

    def coated(angle):
        start = bare(0)
        return residual + (1 - residual) * (bare(angle) - start) / (1 - start)

    s.arrow((0, 0), (wide + 20, 0), INK, 1)
    s.arrow((0, 0), (0, tall + 20), INK, 1)
    for k in range(1, 6):
        s.line([(0, tall * k / 5), (wide, tall * k / 5)], "#e2e2e2", 1)
        s.text((-8, tall * k / 5), "%d %%" % (4 * k), "end", DIM, 11)
    for angle in range(0, 76, 15):
        s.line([(wide * angle / 75, 0), (wide * angle / 75, -5)], INK, 1)
        s.text((wide * angle / 75, -16), "%d°" % angle, "middle", DIM, 11)
    for curve, colour in ((bare, SIGHT), (coated, HUES[2])):
        points = [(wide * a / 75, tall * curve(a) / 0.2) for a in range(0, 76)]
        s.line([p for p in points if p[1] <= tall], colour, 2)
    s.text((wide / 2, -38), "angle of incidence θ")
    s.text((12, tall + 12), "reflectance, one interface", "start")
    s.text((60, 62), "bare: F, F0 = 4 %", "start", SIGHT)
    s.text((60, 16), "`coating` R0 = 0.5 %", "start", HUES[2])
    return s


def retroreflector():
    s = Sketch(560, 290, (230, 50), "Retroreflector: a narrow lobe about the way back, a weak "
               "diffuse one besides")
    angle, spread = 35, math.tan(math.radians(6))

    def back(delta):
        c, v = math.cos(math.radians(delta)), math.sin(math.radians(delta))
        return spread ** 4 * c / (spread ** 2 * c * c + v * v) ** 2

    s.wall((-170, 0), (170, 0))
    s.lobe((0, 0), 90, 42, cosine, "#d5e2f6", BACK)
    s.lobe((0, 0), 90 + angle, 190, back, span=60)
    normal(s, 190)
    s.line([polar((0, 0), 205, 90 + angle), polar((0, 0), 150, 90 + angle)], SIGHT, 1.6)
    s.arrow(polar((0, 0), 228, 90 + angle), polar((0, 0), 192, 90 + angle), SIGHT, 1.6)
    s.text(polar((0, 0), 236, 90 + angle), "light", "end", SIGHT)
    s.angle((0, 0), 66, 90, 90 + angle, "θ")
    s.line([polar((0, 0), 195, 90 + angle - 6), (0, 0)], DIM, 0.8, "4 3")
    s.angle((0, 0), 172, 90 + angle - 6, 90 + angle, "")
    s.text((-66, 178), "`divergence`", "start", DIM)
    s.text((-10, 150), "half of the returned", "start", LIGHT)
    s.text((-10, 133), "light lies within it", "start", LIGHT)
    s.text((50, 34), "`diffuseReflectance`", "start", BACK)
    s.text((-150, 40), "`reflectance` s²(θ)", "middle", LIGHT)
    return s


DRAWINGS = {"diffuse": diffuse, "absorber": absorber, "mirror": mirror,
            "beam-splitter": beam_splitter, "sheet": sheet, "dielectric": dielectric,
            "coating": coating, "retroreflector": retroreflector}

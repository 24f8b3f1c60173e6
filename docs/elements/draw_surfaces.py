# SPDX-License-Identifier: Apache-2.0
"""Exact surfaces: lenses in section with rays that are really traced, and simple bodies."""

import math

from sketch import DIM, EDGE, FAINT, GLASS, INK, LIGHT, Sketch, polar


def sag(r, radius):
    """z of a sphere at the distance r from its axis; a plane has the radius 0."""
    return (
        r * r / (radius + math.copysign(math.sqrt(radius * radius - r * r), radius))
        if radius
        else 0.0
    )


def meet(p, d, vertex, radius):
    """Where the line p + t d meets a sphere through (vertex, 0), and the normal there."""
    if not radius:
        t = (vertex - p[0]) / d[0]
        return (vertex, p[1] + t * d[1]), (1.0, 0.0)
    x, y = p[0] - vertex - radius, p[1]
    b = x * d[0] + y * d[1]
    t = -b - math.copysign(math.sqrt(b * b - x * x - y * y + radius * radius), radius)
    q = (p[0] + t * d[0], p[1] + t * d[1])
    return q, ((vertex + radius - q[0]) / radius, -q[1] / radius)


def refract(d, n, ratio):
    """Snell's law for unit vectors, n along the light; ratio is the index before over that
    behind."""
    c = d[0] * n[0] + d[1] * n[1]
    cosine = math.sqrt(1 - ratio * ratio * (1 - c * c))
    k = cosine - ratio * c
    return (ratio * d[0] + k * n[0], ratio * d[1] + k * n[1])


def trace(p, surfaces, end):
    """A ray parallel to the axis through (vertex, radius, index behind) up to the x of `end`."""
    d, index, path = (1.0, 0.0), 1.0, [p]
    for vertex, radius, behind in surfaces:
        q, n = meet(p, d, vertex, radius)
        d, p, index = refract(d, n, index / behind), q, behind
        path.append(q)
    return path + [(end, p[1] + d[1] / d[0] * (end - p[0]))]


def outline(first, second, half):
    """The section of a lens between two (vertex, radius)."""
    ys = [half * k / 16 for k in range(-16, 17)]
    return [(first[0] + sag(y, first[1]), y) for y in ys] + [
        (second[0] + sag(y, second[1]), y) for y in reversed(ys)
    ]


def lens():
    s = Sketch(
        760,
        340,
        (190, 175),
        "Lens: surfaces in a row along the node's +z, here a cemented " "doublet",
    )
    half = 80
    a, b, c = (0, 190), (52, -150), (78, -560)
    s.axis(-160, 540)
    s.area(outline(a, b, half), GLASS, EDGE)
    s.area(outline(b, c, half), "#c3dcf0", EDGE)
    for first, second in ((a, b), (b, c)):
        for sign in (1, -1):
            s.line([(v[0] + sag(half, v[1]), sign * half) for v in (first, second)], INK, 3)
    surfaces = [(0, 190, 1.5168), (52, -150, 1.6727), (78, -560, 1.0)]
    for y in (58, -58):
        s.ray(trace((-150, y), surfaces, 395), LIGHT, 1.3)
    s.dot((0, 0), "origin", 225, INK, 14)
    s.dimension((0, -half - 6), (52, -half - 6), "", -20)
    s.dimension((52, -half - 6), (78, -half - 6), "", -20)
    s.text((16, -128), "`thickness`", "middle", DIM)
    s.dimension((-20, 0), (-20, half), "`semiDiameter`", 0, 8, at=0.4)
    s.line([(-24, half), (10, half)], DIM, 0.7)
    s.text((-48, -84), "`material` [0]", "end", EDGE)
    s.line([(-46, -80), (26, -44)], EDGE, 0.7)
    s.text((130, -66), "`material` [1]", "start", EDGE)
    s.line([(128, -62), (60, -44)], EDGE, 0.7)
    s.text((120, 104), "`rim`: absorbs without one", "start")
    s.line([(116, 102), (62, half + 2)], DIM, 0.7)
    centre = (190, 0)
    on = (sag(40, 190), 40)
    s.line([centre, on], DIM, 0.9)
    s.head(on, math.degrees(math.atan2(on[1], on[0] - 190)), DIM)
    s.dot(centre, "", 0, DIM)
    s.text((188, -13), "centre: `radius` > 0", "start", DIM)
    s.text((-30, 112), "`surfaces` [0]", "end")
    s.line([(-27, 108), (sag(66, 190) - 1, 66)], DIM, 0.7)
    s.text((535, 12), "+z", "end", FAINT)
    return s


def surface():
    s = Sketch(
        640,
        300,
        (330, 150),
        "Surface: one optical surface by itself, here a paraboloid " "with a hole",
    )
    half, hole, f = 110, 24, 150
    curve = [(-y * y / (4 * f), y) for y in range(-half, half + 1, 2)]
    for sign in (1, -1):
        piece = [p for p in curve if sign * p[1] >= hole]
        s.line(piece, INK, 3)
        s.line([(p[0] + 6, p[1]) for p in piece], FAINT, 1.2, "2 3")
    s.axis(-290, 195)
    for y in (90, 55, -55, -90):
        hit = (-y * y / (4 * f), y)
        s.ray([(-290, y), hit, (-f, 0)], LIGHT, 1.2)
    s.dot((-f, 0), "F", 250, INK, 16)
    s.dot((0, 0), "origin", 240, INK, 14)
    s.dimension((60, 0), (60, -half), "`semiDiameter`", 0)
    s.line([(-half * half / (4 * f), -half), (66, -half)], DIM, 0.7)
    s.dimension((60, hole), (60, 0), "`holeRadius`", 0)
    s.line([(0, hole), (66, hole)], DIM, 0.7)
    s.text((44, 100), "`conic` = -1", "start", DIM)
    s.text((44, 83), "`radius` = -2 f < 0:", "start", DIM)
    s.text((44, 66), "its centre lies towards -z", "start", DIM)
    s.text((-200, 124), "front, towards -z")
    s.text((195, 12), "+z", "end", FAINT)
    return s


def ellipse(s, centre, a, b, first=0, last=360, colour=INK, width=1.4, dash=None):
    points = [
        (centre[0] + a * math.cos(math.radians(t)), centre[1] + b * math.sin(math.radians(t)))
        for t in range(first, last + 1, 5)
    ]
    s.line(points, colour, width, dash)
    return points


def axes(s, at, z="+z"):
    """z to the right, y up, x away from the reader."""
    for tip, words, spot in (
        ((30, 0), z, (42, 0)),
        ((0, 30), "y", (0, 40)),
        ((17, 17), "x", (25, 21)),
    ):
        s.arrow(at, (at[0] + tip[0], at[1] + tip[1]), FAINT, 1.1)
        s.text((at[0] + spot[0], at[1] + spot[1]), words, "middle", FAINT, 11)


def disc():
    s = Sketch(480, 240, (190, 120), "Disc: a plane surface with an edge, and perhaps a hole")
    a, b = 34, 90
    s.area(ellipse(s, (0, 0), a, b), GLASS, INK)
    s.area(ellipse(s, (0, 0), a * 0.3, b * 0.3), "#ffffff", INK)
    s.dot((0, 0))
    s.dimension((0, 0), (0, b), "")
    s.line([(0, 66), (54, 82)], DIM, 0.7)
    s.text((58, 84), "`radius`", "start", DIM)
    s.line([(4, -26), (54, -50)], DIM, 0.7)
    s.line([(0, 0), (0, -27)], DIM, 0.9)
    s.text((58, -52), "`holeRadius` (0: no hole)", "start", DIM)
    s.arrow((-40, 0), (-110, 0), FAINT)
    s.text((-80, 16), "front, -z", "middle", FAINT)
    axes(s, (120, 8))
    return s


def box():
    s = Sketch(480, 260, (170, 110), "Box: width along x, height along y, depth along z")
    w, h, d = 60, 110, 130  # x leads away from the reader, to the upper right
    x = (0.5 * w, 0.5 * w)

    def corner(i, j, k):
        return (k * d - d / 2 + i * x[0] - x[0] / 2, j * h - h / 2 + i * x[1] - x[1] / 2)

    s.area([corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)], GLASS, EDGE)
    s.area([corner(1, 1, 0), corner(1, 1, 1), corner(0, 1, 1), corner(0, 1, 0)], "#eaf5fc", EDGE)
    s.area([corner(1, 0, 1), corner(0, 0, 1), corner(0, 1, 1), corner(1, 1, 1)], "#c3dcf0", EDGE)
    s.dimension(corner(0, 0, 0), corner(0, 0, 1), "`depth`", -18)
    s.dimension(corner(0, 0, 0), corner(0, 1, 0), "`height`", 18)
    s.dimension(corner(0, 0, 1), corner(1, 0, 1), "", -14)
    s.text((corner(1, 0, 1)[0] + 14, corner(1, 0, 1)[1] - 26), "`width`", "start", DIM)
    s.dot((0, 0), "origin", 40)
    axes(s, (190, 20))
    return s


def cylinder():
    s = Sketch(480, 240, (190, 125), "Cylinder: along z, about the node's origin")
    a, b, half = 24, 70, 95
    s.area(
        [(-half, b), (half, b)]
        + ellipse(s, (half, 0), a, b, -90, 90, EDGE)[::-1]
        + [(-half, -b)]
        + ellipse(s, (-half, 0), a, b, 90, 270, EDGE)[::-1],
        GLASS,
        EDGE,
    )
    s.area(ellipse(s, (half, 0), a, b, 0, 360, EDGE), "#c3dcf0", EDGE)
    s.line([(-half - 40, 0), (half + 50, 0)], FAINT, 1, "12 4 2 4")
    s.dot((0, 0), "origin", 90)
    s.dimension((-half, -b), (half, -b), "`length`", -20)
    s.dimension((half, 0), (half, b), "", 0)
    s.line([(half, 50), (half + 44, 62)], DIM, 0.7)
    s.text((half + 48, 64), "`radius`", "start", DIM)
    axes(s, (190, -60))
    return s


def sphere():
    s = Sketch(480, 230, (190, 115), "Sphere: about the node's origin")
    s.circle((0, 0), 85, GLASS, EDGE)
    ellipse(s, (0, 0), 85, 22, 180, 360, EDGE, 1)
    ellipse(s, (0, 0), 85, 22, 0, 180, EDGE, 1, "4 3")
    tip = polar((0, 0), 85, 40)
    s.line([(0, 0), tip], DIM, 0.9)
    s.head(tip, 40, DIM)
    s.text((72, 66), "`radius`", "start", DIM)
    s.dot((0, 0), "origin", 200)
    axes(s, (140, -40))
    return s


DRAWINGS = {
    "lens": lens,
    "surface": surface,
    "disc": disc,
    "box": box,
    "cylinder": cylinder,
    "sphere": sphere,
}

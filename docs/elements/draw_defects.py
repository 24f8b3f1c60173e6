# SPDX-License-Identifier: Apache-2.0
"""Defects: the cross-sections of dents and of scratches."""

import math

from sketch import DIM, EDGE, FAINT, HUES, INK, LIGHT, Sketch

SIZE = 150  # of a defect in the drawings
DEPTH = 46


def section(s, at, law, reach, colour=INK, dash=None):
    """The profile depth law(x), x in sizes, around a point."""
    points = []
    for k in range(-120, 121):
        x = reach * k / 120
        points.append((at[0] + SIZE * x, at[1] + DEPTH * law(x)))
    if dash is None:
        low = at[1] - DEPTH - 26
        s.area(points + [(points[-1][0], low), (points[0][0], low)], "#eeeeee")
    s.line(points, colour, 1.6, dash)


def gaussian(x):
    return -math.exp(-8 * x * x)


def cosine(x):
    return -math.cos(math.pi * x) ** 2 if abs(x) < 0.5 else 0


def groove(sharp):
    """The sharp groove of the half-width 1/2, convolved with a triangle of the half-width 1/8."""

    def law(x):
        total = weights = 0
        for k in range(-16, 17):
            weight = 1 - abs(k) / 16
            total += weight * sharp(abs(2 * (x + k / 128)))
            weights += weight
        return total / weights

    deepest = law(0)
    return lambda x: -law(x) / deepest


V = groove(lambda t: max(0, 1 - t))
U = groove(lambda t: max(0, 1 - t * t))


def ridge(x):
    t = abs(2 * x) - 2
    return 0.25 * (1 + math.cos(math.pi * t)) * 0.5 if abs(t) < 1 else 0


def dent():
    s = Sketch(760, 190, (190, 120), "Dent: a Gaussian or a cosine")
    for x, law, name in ((0, gaussian, "gaussian"), (390, cosine, "cosine")):
        section(s, (x, 0), law, 1)
        s.line([(x - 170, 0), (x + 170, 0)], FAINT, 1, "5 4")
        s.dimension((x - SIZE / 2, 0), (x + SIZE / 2, 0), "`size`", 18)
        s.dimension((x, -DEPTH), (x, 0), "`depth`", 0, 12, "start")
        s.arrow((x + 130, 0), (x + 130, 50), EDGE, 1.4)
        s.text((x + 142, 44), "n", "start", EDGE)
        s.text((x - 165, 44), "`%s`" % name, "start", DIM)
    return s


def scratch():
    s = Sketch(860, 190, (240, 120), "Scratch: a V or a U with rounded corners, and its pile-up")
    for x, law, name in ((0, V, "V"), (480, U, "U")):
        section(s, (x, 0), lambda t, law=law: law(t) + ridge(t), 1.5)
        section(s, (x, 0), law, 0.6, HUES[3], "4 3")
        s.line([(x - 225, 0), (x + 225, 0)], FAINT, 1, "5 4")
        s.dimension((x - SIZE / 2, 0), (x + SIZE / 2, 0), "`size`", 34)
        s.dimension((x, -DEPTH), (x, 0), "`depth`", 0, 12, "start")
        s.text((x - 220, 50), "`%s`" % name, "start", DIM)
    s.text((SIZE, 26), "`pileUp`", "middle", LIGHT)
    return s


def dig():
    s = Sketch(430, 190, (215, 120), "Dig: a cap of a sphere with a sharp rim")
    depth = DEPTH / SIZE
    radius = (0.25 + depth * depth) / (2 * depth)

    def law(x):
        return (radius - depth - math.sqrt(radius * radius - x * x)) / depth if abs(x) < 0.5 else 0

    section(s, (0, 0), law, 1)
    s.line([(-170, 0), (170, 0)], FAINT, 1, "5 4")
    s.dimension((-SIZE / 2, 0), (SIZE / 2, 0), "`size`", 18)
    s.dimension((0, -DEPTH), (0, 0), "`depth`", 0, 12, "start")
    return s


CORNER = [(0, 0), (-150, -150), (150, -150)]  # an edge of a part, seen along it


def burr():
    s = Sketch(430, 230, (215, 160), "Burr: a ridge along an edge, seen along it")
    s.area(CORNER, "#eeeeee")
    s.line([CORNER[1], CORNER[0], CORNER[2]], FAINT, 1, "5 4")
    points = [(x, -abs(x) + 1.2 * DEPTH * (math.cos(math.pi * x / SIZE) ** 2
                                           if abs(x) < SIZE / 2 else 0))
              for x in range(-150, 151, 3)]
    s.area(points + [CORNER[2], CORNER[1]], "#eeeeee")
    s.line(points)
    s.line([(-SIZE / 2, -SIZE / 2), (-SIZE / 2, 20)], FAINT, 1, "5 4")
    s.line([(SIZE / 2, -SIZE / 2), (SIZE / 2, 20)], FAINT, 1, "5 4")
    s.dimension((-SIZE / 2, 0), (SIZE / 2, 0), "`size`", 20)
    s.dimension((0, 0), (0, 1.2 * DEPTH), "`depth`", 0, 12, "start")
    s.arrow((-130, 0), (-130, 50), EDGE, 1.4)
    s.text((-118, 44), "n", "start", EDGE)
    return s


def chip():
    s = Sketch(860, 230, (215, 150), "Chip: a ball bites an edge; missing part: a plane cuts it off")
    for x, name in ((0, "chip"), (430, "missingPart")):
        corner = [(x + px, py) for px, py in CORNER]
        s.area(corner, "#eeeeee")
        s.line([corner[1], corner[0], corner[2]], FAINT, 1, "5 4")
        s.arrow((x - 150, 0), (x - 150, 50), EDGE, 1.4)
        s.text((x - 138, 44), "n", "start", EDGE)
        s.text((x - 190, 66), "`%s`" % name, "start", DIM)
    r = 75
    bite = [(r * math.cos(math.radians(a)), r * math.sin(math.radians(a)))
            for a in range(225, 316, 3)]
    s.area([(0, 0)] + bite, "#ffffff")
    s.line([CORNER[1]] + bite + [CORNER[2]])
    s.arc((0, 0), r, -45, 225, FAINT, 1, "5 4")
    s.dimension((-r, 0), (r, 0), "`size`", 12)
    s.dimension((0, -r), (0, 0), "`depth`", 0, 12, "start")
    cut = 70
    s.area([(430, 0), (430 - cut, -cut), (430 + cut, -cut)], "#ffffff")
    s.line([(280, -150), (430 - cut, -cut), (430 + cut, -cut), (580, -150)])
    s.dimension((430, -cut), (430, 0), "`size`", 0, 12, "start")
    return s


def patch():
    s = Sketch(430, 190, (215, 95), "Stain and rough patch: another material within a circle")
    s.area([(-180, -70), (140, -70), (180, 70), (-140, 70)], "#eeeeee", FAINT)
    circle = [(75 * math.cos(math.radians(a)) + 28 * math.sin(math.radians(a)) * 0.5,
               50 * math.sin(math.radians(a))) for a in range(0, 360, 6)]
    s.area(circle, "#d9c7a8", INK)
    s.dimension((-75, 0), (75, 0), "`size`", 0)
    s.text((95, 40), "`material` or `roughness`", "middle", DIM)
    return s


DRAWINGS = {"dent": dent, "scratch": scratch, "dig": dig, "burr": burr, "chip": chip,
            "patch": patch}

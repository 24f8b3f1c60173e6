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


DRAWINGS = {"dent": dent, "scratch": scratch}

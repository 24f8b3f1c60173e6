# SPDX-License-Identifier: Apache-2.0
"""Presets: lights of a catalogue in section, the part below (the node's -z), the camera above."""

import math

from sketch import DIM, FAINT, GLASS, INK, LIGHT, PALE, SIGHT, Sketch, polar


def camera(s, p):
    s.area(
        [
            (p[0] - 16, p[1] + 8),
            (p[0] + 16, p[1] + 8),
            (p[0] + 16, p[1] + 34),
            (p[0] - 16, p[1] + 34),
        ],
        "#dddddd",
        INK,
    )
    s.area(
        [(p[0] - 9, p[1]), (p[0] + 9, p[1]), (p[0] + 12, p[1] + 8), (p[0] - 12, p[1] + 8)],
        GLASS,
        INK,
    )
    s.text((p[0] + 24, p[1] + 22), "camera", "start")


def part(s, y, half=62):
    s.wall((-half, y), (half, y))
    s.text((half + 8, y - 6), "part", "start")


def turned(p, angle):
    c, v = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return (p[0] * c - p[1] * v, p[0] * v + p[1] * c)


def ring():
    s = Sketch(
        640, 320, (280, 175), "Ring light: a band about the view, flat or tilted to the axis"
    )
    inner, outer, tilt = 78, 150, 30
    middle, half = (inner + outer) / 2, (outer - inner) / 2
    s.line([(0, -150), (0, 130)], FAINT, 1, "12 4 2 4")
    for sign in (1, -1):
        s.line([(sign * inner, 0), (sign * outer, 0)], FAINT, 1.2, "5 4")
        # The inner edge goes back (up), the outer one forward (down), until the band faces the
        # axis.
        a, b = (
            (
                sign * (middle + k * half * math.cos(math.radians(tilt))),
                -k * half * math.sin(math.radians(tilt)),
            )
            for k in (-1, 1)
        )
        s.panel(*((a, b) if sign < 0 else (b, a)))
        axis = -90 - sign * tilt
        for k in (-0.75, 0, 0.75):
            at = (
                sign * (middle + k * half * math.cos(math.radians(tilt))),
                -k * half * math.sin(math.radians(tilt)),
            )
            s.arrow(at, polar(at, 52, axis), LIGHT, 1.2)
        if sign > 0:
            at = (middle, 0)
            s.area(
                [at] + [polar(at, 112, axis + 14 * k / 4) for k in range(-4, 5)], LIGHT, opacity=0.2
            )
            s.angle(at, 112, axis, axis - 14, "", 12)
            s.text((108, -100), "`halfAngle` β", "start", DIM)
    s.angle((-middle, 0), half + 14, 180, 180 + tilt, "`tilt`")
    part(s, -120)
    camera(s, (0, 70))
    s.dimension((-inner, 0), (inner, 0), "", 34)
    s.text((-48, 46), "`innerDiameter`", "end", DIM)
    s.dimension((-outer, 0), (outer, 0), "", 62)
    s.text((-92, 74), "`outerDiameter`", "end", DIM)
    s.dimension((232, 0), (232, -120), "h")
    s.line([(outer, 0), (238, 0)], FAINT, 0.8)
    s.line([(110, -120), (238, -120)], FAINT, 0.8)
    return s


def bar():
    s = Sketch(680, 270, (170, 150), "Bar light: a rectangle that shines along -z")
    s.panel((70, 0), (-70, 0))
    for x in (-50, 0, 50):
        s.area(
            [(x, 0)] + [polar((x, 0), 84, -90 + 16 * k / 4) for k in range(-4, 5)],
            LIGHT,
            opacity=0.2,
        )
        s.arrow((x, 0), (x, -84), LIGHT, 1.2)
    s.angle((50, 0), 92, -90, -74, "`halfAngle` β", 12, -76)
    s.dimension((-70, 7), (70, 7), "`length`", 26)
    s.arrow((-130, -60), (-130, -94), FAINT, 1.1)
    s.text((-130, -104), "-z", "middle", FAINT, 11)
    s.arrow((-130, -60), (-96, -60), FAINT, 1.1)
    s.text((-90, -60), "x", "start", FAINT, 11)
    x = 245
    s.area([(x, -18), (x + 160, -18), (x + 160, 18), (x, 18)], PALE, LIGHT)
    s.dimension((x, 18), (x + 160, 18), "`length`", 24)
    s.dimension((x + 160, -18), (x + 160, 18), "`width`", -18)
    s.arrow((x, -75), (x + 34, -75), FAINT, 1.1)
    s.text((x + 42, -75), "x", "start", FAINT, 11)
    s.arrow((x, -75), (x, -41), FAINT, 1.1)
    s.text((x - 10, -45), "y", "end", FAINT, 11)
    s.text((x + 112, -75), "seen along -z", "middle", INK)
    return s


def dome():
    s = Sketch(
        600,
        340,
        (230, 120),
        "Dome light: uniform radiance from a hemisphere with a hole " "for the camera",
    )
    radius, hole = 130, 26
    edge = math.degrees(math.acos(hole / radius))
    for first, last in ((0, edge), (180 - edge, 180)):
        rim = [first + (last - first) * k / 24 for k in range(25)]
        s.area(
            [polar((0, 0), radius, a) for a in rim]
            + [polar((0, 0), radius + 9, a) for a in reversed(rim)],
            PALE,
            LIGHT,
        )
    s.line([(0, -50), (0, 150)], FAINT, 1, "12 4 2 4")
    for angle in (10, 30, 50, 130, 150, 170):
        at = polar((0, 0), radius, angle)
        for turn in (-40, 0, 40):
            s.arrow(at, polar(at, 40, angle + 180 + turn), LIGHT, 1)
    part(s, -12, 44)
    camera(s, (0, 140))
    s.dimension((-radius, 0), (radius, 0), "`diameter` D", -70)
    top = radius * math.sin(math.radians(edge))
    s.dimension((-hole, top), (hole, top), "", -34)
    s.text((0, top - 46), "`holeDiameter` d", "middle", DIM)
    s.text((160, 70), "`radiance` L,", "start", LIGHT)
    s.text((160, 53), "the same everywhere", "start", LIGHT)
    s.text((160, 36), "and in all directions", "start", LIGHT)
    return s


def coaxial():
    s = Sketch(
        640, 340, (250, 185), "Coaxial light: a half mirror at 45 degrees and a panel beside " "it"
    )
    h = 104  # the window's height; y of the node to the right, z up
    s.line([(0, -150), (0, 130)], FAINT, 1, "12 4 2 4")
    s.line([(-h / 2, -h / 2), (h / 2, h / 2)], "#2b7bb9", 3.5)
    x = 0.55 * h
    s.panel((x, -h / 2), (x, h / 2), 9)
    s.line([(-x, -h / 2), (-x, h / 2)], INK, 6)
    for y in (-24, 22):
        s.ray(
            [
                (x, y),
                (y, y),
                (y, -118),
            ],
            LIGHT,
            1.3,
        )
    s.line([(22, 22), (-x, 22)], LIGHT, 1, "4 3")
    s.ray([(0, -118), (0, 68)], SIGHT, 1.8)
    part(s, -120, 60)
    camera(s, (0, 75))
    s.text((x + 18, 8), "panel: `radiance`,", "start", LIGHT)
    s.text((x + 18, -9), "`halfAngle` or diffuse", "start", LIGHT)
    s.text((-x - 10, 18), "black wall", "end")
    s.text((84, 78), "half mirror:", "start", "#2b7bb9")
    s.text((84, 61), "`reflectance`, `transmittance`", "start", "#2b7bb9")
    s.line([(81, 70), (h / 2 + 1, h / 2 + 1)], "#2b7bb9", 0.7)
    s.dimension((-h / 2, -h / 2), (h / 2, -h / 2), "", -30)
    s.text((-62, -84), "window: `size` [1]", "end", DIM)
    s.dimension((0, 0), (x, 0), "", 48)
    s.text((-62, 62), "0.55 `size` [1]", "end", DIM)
    s.line([(-60, 58), (10, 49)], DIM, 0.7)
    s.arrow((-200, -100), (-166, -100), FAINT, 1.1)
    s.text((-160, -100), "y", "start", FAINT, 11)
    s.arrow((-200, -100), (-200, -66), FAINT, 1.1)
    s.text((-210, -70), "z", "end", FAINT, 11)
    return s


DRAWINGS = {"ring": ring, "bar": bar, "dome": dome, "coaxial": coaxial}

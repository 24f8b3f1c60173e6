# SPDX-License-Identifier: Apache-2.0
"""Emitters with a surface, from the side: they send light to the right, along the node's -z."""

import math

from sketch import DIM, FAINT, HUES, INK, LIGHT, PALE, Sketch, polar

GREYS = ("#f2f2f2", "#8c8c8c", "#d0d0d0", "#303030", "#b0b0b0", "#5a5a5a")


def frame(s, at):
    """The node's axes: -z to the right, y up."""
    s.arrow(at, (at[0] + 34, at[1]), FAINT, 1.1)
    s.arrow(at, (at[0], at[1] + 34), FAINT, 1.1)
    s.text((at[0] + 36, at[1] - 10), "-z", "middle", FAINT, 11)
    s.text((at[0] - 9, at[1] + 32), "y", "middle", FAINT, 11)


def cone(s, p, half, length, colour=LIGHT, axis=0):
    """A cone of this half-angle [deg] about the normal."""
    edge = [polar(p, length, axis + half * k / 6) for k in range(-6, 7)]
    s.area([p] + edge, colour, opacity=0.18)
    for sign in (1, -1):
        s.line([p, polar(p, length, axis + sign * half)], colour, 1)


def area():
    s = Sketch(520, 260, (150, 135), "Area emitter: the radiance is the same in all directions")
    half = 85
    s.panel((0, -half), (0, half), -9)
    for y in (49, -49):
        s.lobe((0, y), 0, 88, lambda a: math.cos(math.radians(a)))
        for angle in (-60, -30, 0, 30, 60):
            s.arrow((0, y), polar((0, y), 88 * math.cos(math.radians(angle)), angle), LIGHT, 1)
    s.arrow((0, 0), (150, 0), INK)
    s.text((156, 0), "q_n", "start")
    s.angle((0, 49), 44, 0, 30, "θ", 9)
    s.text((106, 58), "I(θ) ∝ cos θ:", "start", LIGHT)
    s.text((106, 40), "the same `radiance` L in all directions", "start", LIGHT)
    s.dimension((-9, -half), (-9, half), "`size`", 24)
    frame(s, (180, -95))
    return s


def parallel():
    s = Sketch(
        580,
        290,
        (130, 150),
        "Parallel emitter: every point sends its radiance into a cone " "about the normal",
    )
    half, beta = 95, 14
    s.panel((0, -half), (0, half), -9)
    for y in (72, -72):
        cone(s, (0, y), beta, 150)
    cone(s, (0, 0), beta, 250)
    s.arrow((0, 0), (300, 0), INK)
    s.text((306, 0), "q_n", "start")
    s.arrow((0, 0), polar((0, 0), 250, 8), HUES[0], 1.8)
    s.text(polar((0, 0), 264, 9), "q_d", "start", HUES[0])
    s.dot((0, 0), "q_i", 205, HUES[0], 18)
    s.angle((0, 0), 268, 0, -beta, "`halfAngle` β")
    s.text((158, 92), "`radiance` L within the cone,", "start", LIGHT)
    s.text((158, 75), "nothing outside it", "start", LIGHT)
    s.dimension((-9, -half), (-9, half), "`size`", 24)
    frame(s, (330, -120))
    return s


def collimated_beam():
    s = Sketch(660, 280, (140, 150), "Collimated beam: all light leaves along the normal")
    half = 80
    s.panel((0, -half), (0, half), -9)
    for y in range(-70, 71, 20):
        s.ray([(0, y), (235, y)], LIGHT)
    s.line([(190, -95), (190, 95)], FAINT, 1.2, "6 4")
    s.text((194, 106), "`irradiance` E on a plane across the beam", "middle", LIGHT)
    s.dimension((-9, -half), (-9, half), "`size`", 24)
    x, y = 375, 5
    s.area([(x - 70, y - 60), (x + 70, y - 60), (x + 70, y + 60), (x - 70, y + 60)], PALE, LIGHT)
    s.circle((x, y), 60, "none", LIGHT, 1.4, "5 3")
    s.text((x, y + 8), "`aperture`:", "middle", INK)
    s.text((x, y - 9), "square or circle")
    s.dimension((x - 70, y - 60), (x + 70, y - 60), "`size` [0]", -18)
    s.dimension((x + 70, y - 60), (x + 70, y + 60), "`size` [1]", -16, 8)
    frame(s, (225, -120))
    return s


def laser():
    s = Sketch(700, 300, (60, 160), "Laser: a Gaussian beam with its waist, and a fan that draws a line")
    waist, middle, rayleigh = 9, 175, 62
    width = lambda z: waist * math.hypot(1, (z - middle) / rayleigh)
    upper = [(z, width(z)) for z in range(0, 341, 10)]
    s.area(upper + [(z, -w) for z, w in reversed(upper)], LIGHT, opacity=0.22)
    for sign in (1, -1):
        for (z, w), (y, v) in zip(upper, upper[1:]):
            s.line([(z, sign * w), (y, sign * v)], LIGHT, 1.2)
    s.axis(-10, 350)
    s.line([(0, -45), (0, 45)], INK, 2)
    s.text((0, 56), "node")
    s.dimension((0, -50), (middle, -50), "`workingDistance`", -18)
    s.dimension((middle, -waist), (middle, waist), "2 w_0", -26, 12, "start")
    s.text((250, 62), "w(z), M²: 1/e² radius", "middle", LIGHT)
    s.angle((middle, 0), 130, 0, math.degrees(math.atan(waist / rayleigh)), "Θ", 12)
    o, half, r = (430, 0), 27, 165
    arc = [polar(o, r, half * k / 12) for k in range(-12, 13)]
    s.area([o] + arc, LIGHT, opacity=0.18)
    s.arc(o, r, -half, half, LIGHT, 2.6)
    for k in range(-3, 4):
        s.line([o, polar(o, r, half * k / 3)], LIGHT, 0.8)
    s.dot(o, "node", 120, INK, 14)
    s.angle(o, 74, -half, half, "`fanAngle` Φ", 40)
    s.text((430 + 110, 100), "focus at ρ = `workingDistance`", "middle", DIM, 12)
    s.text((430 + 110, -104), "seen across the line", "middle", FAINT, 12)
    frame(s, (20, -125))
    return s


def picture(s, left, low, across, down, size, words=True):
    """The image of a projector as its node's frame has it: x to the right, y up."""
    for row in range(down):
        for column in range(across):
            x, y = left + column * size, low + (down - 1 - row) * size
            s.area(
                [(x, y), (x + size, y), (x + size, y + size), (x, y + size)],
                GREYS[(2 * row + 5 * column + row * column) % 6],
                INK,
                width=0.7,
            )
    if words:
        s.text(
            (left + across * size / 2, low + down * size + 14),
            "column 0 … W - 1",
            "middle",
            DIM,
            11,
        )
        s.text((left - 6, low + down * size - size / 2), "row 0", "end", DIM, 11)
        s.text((left - 6, low + size / 2), "H - 1", "end", DIM, 11)
        s.arrow((left - 52, low), (left - 52, low + 30), FAINT, 1.1)
        s.arrow((left - 52, low), (left - 22, low - 0), FAINT, 1.1)
        s.text((left - 62, low + 30), "y", "middle", FAINT, 11)
        s.text((left - 22, low - 10), "x", "middle", FAINT, 11)


def telecentric_projector():
    s = Sketch(
        720,
        290,
        (150, 150),
        "Telecentric projector: each pixel of a picture is a parallel " "emitter of its own",
    )
    half, beta, pixels = 90, 9, 6
    tall = 2 * half / pixels
    for i in range(pixels):
        y = half - i * tall
        s.area([(0, y), (0, y - tall), (-9, y - tall), (-9, y)], GREYS[i], INK, width=0.8)
        cone(s, (0, y - tall / 2), beta, 165, GREYS[i] if i != 0 else LIGHT)
    y = half - 1.5 * tall
    s.arrow((0, y), polar((0, y), 190, 5), HUES[0], 1.8)
    s.text(polar((0, y), 202, 5), "q_d", "start", HUES[0])
    s.dot((0, y), "q_i", 200, HUES[0], 22)
    s.line([(0, -half + tall / 2), (215, -half + tall / 2)], INK, 1, "5 3")
    s.angle((0, -half + tall / 2), 165, 0, beta, "", 12)
    s.text((220, -half + tall / 2 + 14), "`halfAngle` β", "start", DIM)
    s.text((100, 116), "L × the pixel's value, into its cone", "middle", LIGHT)
    s.dimension((-9, -half), (-9, half), "`size` [1]", 40)
    picture(s, 405, -42, 5, 4, 22)
    s.text((440, -76), "the `image` on the rectangle,")
    s.text((440, -93), "as seen from behind it")
    frame(s, (250, -125))
    return s


def screen():
    s = Sketch(720, 300, (120, 150), "Screen: pixels with gaps, a fall-off and a bent surface")
    half, rise, n = 100, 16, 2

    def edge(y, behind=0):
        return (rise * (y / half) ** 2 - behind, y)

    rows = [-half + 2 * half * k / 20 for k in range(21)]
    s.area([edge(y) for y in rows] + [edge(y, 12) for y in reversed(rows)], PALE, LIGHT)
    s.line([(0, -half - 14), (0, half + 14)], FAINT, 1, "4 3")
    s.dimension((0, half + 4), (rise, half + 4), "`sag` s", 14)
    s.lobe((0, 0), 0, 120, lambda a: math.cos(math.radians(a)) ** n)
    s.arrow((0, 0), (150, 0), INK)
    s.arrow((0, 0), polar((0, 0), 120 * math.cos(math.radians(35)) ** n, 35), HUES[0], 1.8)
    s.angle((0, 0), 56, 0, 35, "θ", 10)
    s.text((150, 62), "L · v^γ · cosⁿ θ", "start", LIGHT)
    s.dimension((-12, -half), (-12, half), "height", 24)
    pitch, gap, left, top = 42, 9, 325, 84
    for row in range(4):
        for column in range(6):
            x, y = left + column * pitch, top - row * pitch
            s.area(
                [
                    (x + gap / 2, y - gap / 2),
                    (x + pitch - gap / 2, y - gap / 2),
                    (x + pitch - gap / 2, y - pitch + gap / 2),
                    (x + gap / 2, y - pitch + gap / 2),
                ],
                GREYS[column],
                INK,
                width=0.8,
            )
    s.dimension(
        (left + pitch / 2, top + 4), (left + 1.5 * pitch, top + 4), "`pixelPitch` p", 14
    )
    right = left + 4 * pitch
    s.dimension(
        (right - gap / 2, top - 4 * pitch - 3),
        (right + gap / 2, top - 4 * pitch - 3),
        "`pixelGap` g",
        -16,
    )
    s.text((left + 3 * pitch, -136), "the `image` as an observer sees it")
    return s


def projector():
    s = Sketch(740, 320, (215, 165), "Projector: the thin lens camera reversed")
    f, w, half, pixels = 62, 340, 44, 4
    b = f * w / (w - f)
    m = b / w
    tall = 13
    s.axis(-170, 440)
    s.lens(0, half)
    for i in range(pixels):
        y = (pixels / 2 - i) * tall
        s.area([(-b, y), (-b, y - tall), (-b - 9, y - tall), (-b - 9, y)], GREYS[i], INK, width=0.8)
        s.area(
            [(w, -y / m), (w, -(y - tall) / m), (w + 9, -(y - tall) / m), (w + 9, -y / m)],
            GREYS[i],
            INK,
            width=0.8,
        )
    pixel = (-b, tall / 2)
    spot = (w, -pixel[1] / m)
    s.area([pixel, (0, half), spot, (0, -half)], LIGHT, opacity=0.18)
    for y in (half, 0, -half):
        s.ray([pixel, (0, y), spot], LIGHT, 1.2)
    s.dot((-62, 0), "F", 300, INK, 13)
    s.text((w + 16, 48), "plane in focus", "start")
    s.text((-b - 14, 44), "`image` or `pattern`", "end", INK)
    s.dimension((-b - 9, -tall), (-b - 9, 0), "`pixelSize`", 18)
    s.dimension((-b, -2 * tall), (0, -2 * tall), "`imageDistance` b", -94)
    s.dimension((0, -half), (w, -half), "`focusDistance` = throw", -76)
    s.dimension((0, half), (0, -half), "", 22)
    s.text((14, 62), "`lensDiameter` D", "start", DIM)
    s.dimension((-f, 0), (0, 0), "`focalLength` f", 96)
    s.text((435, 12), "-z", "end", FAINT)
    return s


def light_field_emitter():
    s = Sketch(
        760,
        330,
        (60, 60),
        "Light field emitter: macro pixels say where, the pixels in them " "in which direction",
    )
    size, count = 12, 5
    macro = size * count
    hues = ("#e9a29c", "#f3cf8f", "#a7d3b4", "#a9bfe8")
    for my in range(3):
        for mx in range(4):
            for k in range(count):
                for j in range(count):
                    x, y = mx * macro + j * size, my * macro + k * size
                    tone = hues[(j * 2 + k * 3 + mx + my) % 4]
                    s.area(
                        [(x, y), (x + size, y), (x + size, y + size), (x, y + size)],
                        tone,
                        "#ffffff",
                        width=0.5,
                    )
            x, y = mx * macro, my * macro
            s.area(
                [(x, y), (x + macro, y), (x + macro, y + macro), (x, y + macro)],
                "none",
                INK,
                width=1.6,
            )
    s.dimension((0, 0), (4 * macro, 0), "`spatialResolution`: M × N macro pixels", -22)
    s.dimension((0, 3 * macro), (macro, 3 * macro), "", 12)
    s.text((-4, 3 * macro + 32), "`angularResolution`: J × K pixels of a macro pixel", "start", DIM)
    s.text((120, -46), "the `image`: M·J × N·K pixels")
    # The hemisphere from the side, over the centre of one macro pixel.
    o, radius = (515, 50), 130
    s.panel((o[0] - 150, o[1]), (o[0] + 150, o[1]), 9)
    s.arc(o, radius, 0, 180, FAINT, 1.2, "6 4")
    for j in range(count + 1):
        x = o[0] + radius * (2 * j / count - 1)
        s.line([(x, o[1]), (x, o[1] - 9)], INK, 1.2)
        s.text(
            (x + radius / count, o[1] - 22), "j = %d" % j if j < count else "", "middle", DIM, 11
        )
    i = polar(o, radius, 37)
    s.area(
        [
            (o[0] + radius * 0.6, o[1]),
            (o[0] + radius * 0.6, o[1] - 9),
            (o[0] + radius, o[1] - 9),
            (o[0] + radius, o[1]),
        ],
        HUES[0],
        INK,
        width=0.6,
    )
    s.arrow(o, i, HUES[0], 1.8)
    s.line([i, (i[0], o[1])], HUES[1], 1.2, "4 3")
    s.dot(o, "o", 120, INK, 14)
    s.dot(i, "i = o + d", 30, HUES[0])
    s.text(polar(o, radius * 0.55, 50), "d", "end", HUES[0])
    s.text((o[0] + 6, o[1] + radius + 14), "unit hemisphere over o", "middle", FAINT)
    s.text((o[0] + 56, o[1] + 12), "d_x", "middle", HUES[1])
    s.dimension((o[0], o[1] - 50), (o[0] - radius, o[1] - 50), "`angularRange` a")
    s.text((o[0] - 65, o[1] - 77), "(1: up to 90°)", "middle", DIM)
    return s


DRAWINGS = {
    "area": area,
    "parallel": parallel,
    "collimated-beam": collimated_beam,
    "laser": laser,
    "telecentric-projector": telecentric_projector,
    "screen": screen,
    "projector": projector,
    "light-field-emitter": light_field_emitter,
}

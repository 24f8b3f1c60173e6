# SPDX-License-Identifier: Apache-2.0
"""Lights without a surface of their own: point, spot, directional and environment."""

from sketch import DIM, FAINT, INK, LIGHT, PALE, Sketch, polar


def point():
    s = Sketch(560, 280, (175, 140), "Point light: the same intensity in all directions")
    for k in range(16):
        s.arrow(polar((0, 0), 12, 22.5 * k), polar((0, 0), 74, 22.5 * k), LIGHT, 1.2)
    s.circle((0, 0), 5, LIGHT, LIGHT)
    s.circle((0, 0), 122, "none", FAINT, 1, "6 4")
    s.wall((235, -75), (235, 75))
    s.line([(0, 0), (235, 0)], INK, 1, "4 3")
    s.dimension((0, 0), (235, 0), "r", 0, 10, at=0.68)
    s.text((250, 14), "E = I / r²", "start")
    s.text((250, -8), "facing the light", "start")
    s.text((0, 94), "`intensity` I", "middle", LIGHT)
    s.line([polar((0, 0), 1, 0), polar((0, 0), 122, 304)], DIM, 0.9)
    s.head(polar((0, 0), 122, 304), 304, DIM)
    s.text(polar((0, 0), 136, 304), "`range` R", "start", DIM)
    return s


def spot():
    s = Sketch(620, 300, (70, 150), "Spot light: full within the inner cone, none beyond the outer "
               "one")
    inner, outer, reach = 15, 32, 235
    s.area([(0, 0)] + [polar((0, 0), reach, outer * k / 12) for k in range(-12, 13)], PALE, "none",
           0.6)
    s.area([(0, 0)] + [polar((0, 0), reach, inner * k / 6) for k in range(-6, 7)], LIGHT, "none",
           0.35)
    for angle in (inner, -inner, outer, -outer):
        s.line([(0, 0), polar((0, 0), reach, angle)], LIGHT, 1)
    s.circle((0, 0), 5, LIGHT, LIGHT)
    s.axis(-40, 290)
    s.angle((0, 0), 150, 0, inner, "")
    s.text(polar((0, 0), 120, 6), "θ_i", "middle", DIM)
    s.angle((0, 0), 190, 0, -outer, "")
    s.text(polar((0, 0), 172, -22), "θ_o", "middle", DIM)
    s.text((-36, 92), "θ_i: `innerConeAngle`", "start", DIM)
    s.text((-36, -96), "θ_o: `outerConeAngle`", "start", DIM)
    s.text((280, 12), "-z", "end", FAINT)
    x, y, wide, tall = 350, -70, 170, 120
    s.arrow((x, y), (x + wide + 14, y), INK, 1)
    s.arrow((x, y), (x, y + tall + 22), INK, 1)
    s.text((x - 10, y + tall), "I", "end", LIGHT)
    s.text((x + wide + 14, y - 14), "θ", "middle", DIM)
    at = [x + wide * angle / 40 for angle in (inner, outer)]
    edge = [((at[0] + (at[1] - at[0]) * t / 20), y + tall * (1 - t / 20) ** 2) for t in range(21)]
    s.line([(x, y + tall)] + edge + [(x + wide, y)], LIGHT, 2)
    s.line([(at[0], y), (at[0], y + tall)], FAINT, 1, "4 3")
    s.text((at[0], y - 14), "θ_i", "middle", DIM)
    s.text((at[1], y - 14), "θ_o", "middle", DIM)
    s.text((x + wide / 2 + 18, y + tall + 12), "`intensity` I, then I a²", "middle", LIGHT)
    return s


def directional():
    s = Sketch(520, 250, (40, 125), "Directional light: parallel rays from infinitely far away")
    for y in range(-80, 81, 20):
        s.ray([(10, y), (235, y)], LIGHT)
    s.line([(250, -100), (250, 100)], FAINT, 1.2, "6 4")
    s.text((262, 62), "`irradiance` E", "start", LIGHT)
    s.text((262, 45), "on a plane across the light,", "start", LIGHT)
    s.text((262, 28), "everywhere in the scene", "start", LIGHT)
    s.arrow((280, -60), (330, -60), FAINT, 1.1)
    s.text((336, -60), "the node's -z", "start", FAINT)
    s.text((-4, 0), "∞", "middle", INK, 20)
    return s


def environment():
    s = Sketch(700, 300, (160, 145), "Environment: radiance from everywhere behind the scene, by "
               "longitude and latitude")
    s.circle((0, 0), 112, "none", LIGHT, 6)
    for k in range(12):
        s.arrow(polar((0, 0), 106, 30 * k + 15), polar((0, 0), 58, 30 * k + 15), LIGHT, 1.1)
    s.area([(-22, -16), (22, -16), (22, 16), (-22, 16)], "#dddddd", INK)
    s.text((0, 0), "scene")
    s.arrow((0, 22), (0, 52), FAINT, 1.1)
    s.text((10, 44), "-z", "start", FAINT, 11)
    s.arrow((26, 0), (52, 0), FAINT, 1.1)
    s.text((50, -12), "x", "middle", FAINT, 11)
    s.text((0, -132), "seen from above, at infinity")
    x, y, wide, tall = 195, -65, 300, 150
    s.area([(x, y), (x + wide, y), (x + wide, y + tall), (x, y + tall)], PALE, LIGHT)
    for k in range(1, 4):
        s.line([(x + wide * k / 4, y), (x + wide * k / 4, y + tall)], FAINT, 0.8, "4 3")
    s.line([(x, y + tall / 2), (x + wide, y + tall / 2)], FAINT, 0.8, "4 3")
    for k, words in enumerate(("+z", "-x", "-z", "+x", "+z")):
        s.dot((x + wide * k / 4, y + tall / 2))
        s.text((x + wide * k / 4, y + tall / 2 + 14), words)
    s.text((x + wide / 2, y + tall - 14), "+y")
    s.text((x + wide / 2, y + 14), "-y")
    s.dimension((x, y), (x + wide, y), "column 0 … W", -20)
    s.dimension((x + wide, y), (x + wide, y + tall), "", -18)
    s.text((x + wide + 4, y + tall + 14), "row 0", "start", DIM)
    s.text((x + wide + 4, y - 12), "row H", "start", DIM)
    s.text((x, y + tall + 14), "the `image`", "start")
    return s


DRAWINGS = {"point": point, "spot": spot, "directional": directional, "environment": environment}

# SPDX-License-Identifier: Apache-2.0
"""Sensors from the side: the scene lies to the right, the optical axis is z of the optical
frame."""

import math

from sketch import DIM, EDGE, FAINT, FILM, GLASS, HUES, INK, LIGHT, PALE, SIGHT, Sketch, polar


def pinhole():
    s = Sketch(650, 270, (270, 140), "Pinhole camera: image plane, pinhole and two camera rays")
    b, half, far = 150, 60, 300
    s.axis(-220, 360)
    s.film(-b, -half, half, 8)
    s.stop(0, 2.5, 90)
    for y in (half - 7.5, -half + 7.5):
        s.ray([(-b, y), (0, 0), (far, -y * far / b)], SIGHT)
    s.dot((-b, half - 7.5), "s", 40, SIGHT)
    s.text((far + 6, -(half - 7.5) * far / b + 4), "d", "start", SIGHT)
    s.dimension((-b, -half), (0, -half), "`imageDistance` b", -52)
    s.dimension((-b - 7, -half), (-b - 7, half), "", 22)
    s.text((-b - 36, 46), "`resolution`", "end", DIM)
    s.text((-b - 36, 30), "×", "end", DIM)
    s.text((-b - 36, 14), "`pixelSize`", "end", DIM)
    s.text((6, 100), "pinhole = origin", "start")
    s.text((-b, 84), "image plane")
    s.text((350, 12), "z", "end", FAINT)
    return s


def thin_lens():
    s = Sketch(
        720,
        330,
        (250, 180),
        "Thin lens camera: a camera ray from the film through the " "lens to the plane in focus",
    )
    f, w, half = 80, 300, 72
    b = f * w / (w - f)
    m = b / w
    image = (-b, 20)
    focused = (w, -20 / m)
    s.axis(-200, 440)
    s.area([image, (0, half), focused, (0, -half)], "#f3d3d5", opacity=0.35)
    s.lens(0, half)
    s.film(-b, -55, 55, 8)
    s.line([(w, -125), (w, 100)], FAINT, 1.2, "6 4")
    for y in (half, -half):
        s.line([image, (0, y), focused], SIGHT, 0.9, "4 3")
    s.ray([image, (0, 38), focused], SIGHT, 1.8)
    past = 1.35
    s.line([focused, (w * past, 38 + (focused[1] - 38) * past)], SIGHT, 1.8)
    s.dot(image, "s", 130, SIGHT)
    s.dot((0, 38), "o", 40, SIGHT, 14)
    s.dot(focused, "w", 235, SIGHT, 14)
    s.dot((-f, 0), "F", 300, INK, 14)
    s.dot((f, 0), "F", 300, INK, 14)
    s.text((w, 112), "plane in focus")
    s.text((-b, 72), "image plane")
    s.text((w * past + 6, 38 + (focused[1] - 38) * past), "d", "start", SIGHT)
    s.dimension((-b, -55), (0, -55), "`imageDistance` b", -75)
    s.dimension((0, -half), (w, -half), "`focusDistance` w", -58)
    s.dimension((0, half), (f, half), "`focalLength` f", 28)
    s.dimension((-14, -half), (-14, half), "", 0)
    s.text((-22, 96), "`lensDiameter` D_l", "end", DIM)
    s.line([(-24, 90), (-15, 60)], DIM, 0.7)
    s.text((432, 12), "z", "end", FAINT)
    return s


def telecentric():
    s = Sketch(
        760,
        380,
        (300, 205),
        "Telecentric camera: every chief ray is parallel to the axis " "on the object's side",
    )
    f, b, stop, half = 105, 175, 13, 104
    m = (b - f) / f
    work = b * f / (b - f)
    s.axis(-225, 400)
    s.lens(0, half)
    s.film(-b, -58, 58, 8)
    s.stop(-f, stop, 66)
    s.line([(work, -130), (work, 130)], FAINT, 1.2, "6 4")

    def sight(y, a):
        o = y + (a - y) * b / (b - f)
        return [(-b, y), (-f, a), (0, o), (work, -y / m)]

    for y in (44, 0, -44):
        s.ray(sight(y, 0), SIGHT, 1.6 if y else 1.1)
        for a in (stop, -stop):
            s.line(sight(y, a), SIGHT, 0.8, "4 3")
    path = sight(44, stop)
    s.ray(path, SIGHT, 1.8)
    s.dot(path[0], "s", 130, SIGHT)
    s.dot(path[1], "a", 70, SIGHT, 14)
    s.dot(path[2], "o", 60, SIGHT, 14)
    s.dot(path[3], "w", 320, SIGHT)
    s.text((work / 2 + 10, 80), "chief rays: parallel to the axis", "middle", SIGHT)
    s.text((-b, 76), "image plane")
    s.text((-f + 6, 84), "stop", "middle")
    s.text((work, 142), "plane in focus")
    s.dimension((-b, -58), (0, -58), "`imageDistance` b", -104)
    s.dimension((-f, -66), (0, -66), "`focalLength` f", -62)
    s.dimension((0, -half), (work, -half), "`workingDistance` W", -58)
    s.dimension((-f - 9, -stop), (-f - 9, stop), "", 0)
    s.line([(-f - 9, -6), (-f - 44, -84)], DIM, 0.7)
    s.text((-f - 40, -92), "`stopDiameter` D_t", "end", DIM)
    s.dimension((work, -44 / m), (work, 44 / m), "", -40)
    s.text((work + 46, 34), "object field", "start", DIM)
    s.dimension((0, -half), (0, half), "", 24)
    s.text((-32, 118), "`lensDiameter` D_l", "middle", DIM)
    s.text((work + 46, 18), "= image / m", "start", DIM)
    s.text((395, -12), "z", "end", FAINT)
    return s


def light_field():
    s = Sketch(
        760,
        360,
        (400, 195),
        "Light field camera: the pixels behind a microlens look at one "
        "focused point through different places of the main lens",
    )
    f, b, half, lenses, pixels = 90, 150, 75, 5, 4
    w = b * f / (b - f)
    pitch = 28
    micro = pitch * b / (2 * half)  # a microlens fills its macro pixel with the image of the lens
    behind = -b - micro
    c = pitch
    focused = (w, -c * w / b)
    grown = 1 + micro / b  # straight lines through the microlenses' centres
    s.axis(-225, 310)
    s.lens(0, half)
    s.line([(w, -120), (w, 90)], FAINT, 1.2, "6 4")
    for i in range(lenses):
        s.lens(-b, pitch / 2, 4, (i - lenses // 2) * pitch)
    top = pitch * lenses / 2 * grown
    s.film(behind, -top, top, lenses * pixels, 8)
    for i in range(lenses + 1):
        y = (i - lenses / 2) * pitch * grown
        s.line([(behind, y), (behind - 8, y)], INK, 2)
    for j in range(pixels):
        o = half * (2 * (j + 0.5) / pixels - 1)
        pixel = (behind, c + (c - o) * micro / b)
        tall = half / pixels * micro / b
        s.area(
            [
                (behind, pixel[1] - tall),
                (behind, pixel[1] + tall),
                (behind - 8, pixel[1] + tall),
                (behind - 8, pixel[1] - tall),
            ],
            HUES[j],
            INK,
            width=0.6,
        )
        s.line([pixel, (-b, c)], HUES[j], 1.2)
        s.ray([(-b, c), (0, o), focused], HUES[j], 1.3)
        s.circle((0, o), 2.4, HUES[j], HUES[j])
    s.dot((-b, c), "c", 60, INK, 15)
    s.dot(focused, "w", 320, INK)
    s.text((12, half * 0.75 + 4), "o", "start", HUES[3])
    s.text((behind - 14, c - 10), "s", "end", HUES[3])
    s.text((-b + 16, 104), "microlenses")
    s.text((w, 102), "plane in focus")
    s.dimension((-b, -70), (0, -70), "`imageDistance` b", -80)
    s.dimension((behind, -top), (-b, -top), "", -28)
    s.text((behind - 4, -top - 30), "f_µ", "end", DIM)
    s.dimension((0, -half), (w, -half), "`focusDistance` w", -75)
    s.dimension((0, half), (f, half), "`focalLength` f", 28)
    s.dot((f, 0), "F", 60, INK, 14)
    s.dimension((14, -half), (14, half), "", 0)
    s.text((22, -half - 12), "`lensDiameter` D_l", "start", DIM)
    s.dimension((behind - 8, -top), (behind - 8, top), "", 52)
    s.text((behind - 8 - 60, -24), "`spatialResolution`", "end", DIM)
    s.text((behind - 8 - 60, -40), "M × N macro pixels", "end", DIM)
    low, high = (c + sign * pitch / 2 * grown for sign in (-1, 1))
    low, high = low + c * (grown - 1), high + c * (grown - 1)
    s.dimension((behind - 8, low), (behind - 8, high), "", 24)
    s.text((behind - 8 - 60, 62), "`angularResolution`", "end", DIM)
    s.text((behind - 8 - 60, 46), "J × K pixels", "end", DIM)
    s.text((behind - 8 - 60, 30), "of `pixelSize`", "end", DIM)
    s.line([(behind - 8 - 57, 46), (behind - 8 - 26, (low + high) / 2 + 2)], DIM, 0.7)
    s.text((305, 12), "z", "end", FAINT)
    return s


def line_scan():
    s = Sketch(
        640, 300, (230, 130), "Line-scan camera: one row of the film sees a line of a moving part"
    )
    b, w, half = 110, 280, 46
    s.axis(-150, 380)
    s.lens(0, half)
    s.film(-b, -48, 48, 9)
    s.area([(-b - 3, -5), (-b + 3, -5), (-b + 3, 5), (-b - 3, 5)], SIGHT)
    for y in (half, -half):
        s.line([(-b, 0), (0, y), (w, 0)], SIGHT, 0.9, "4 3")
    s.ray([(-b, 0), (0, 0), (w, 0)], SIGHT, 1.6)
    s.line([(w, -98), (w, 84)], INK, 2.4)
    s.ray([(w + 26, 40), (w + 26, -40)], HUES[0], 1.8)
    s.text((w + 34, -2), "v", "start", HUES[0])
    s.text((w, 98), "part")
    s.text((-b, 66), "the row that is read")
    s.line([(-b, 60), (-b, 8)], DIM, 0.7)
    s.dimension((-b, -48), (0, -48), "`imageDistance` b", -58)
    s.dimension((0, -half), (w, -half), "`focusDistance` w", -60)
    s.text((372, 12), "z", "end", FAINT)
    return s


def flying_spot():
    s = Sketch(
        700,
        300,
        (150, 150),
        "Flying spot scanner: parallel beams one after the other, a part that turns them aside, and "
        "detectors for each direction behind a collecting lens",
    )
    part, lens, plane = 190, 330, 440
    s.axis(-120, 500)
    s.line([(0, -70), (0, 90)], INK, 2.2)
    s.text((0, 104), "scanner")
    for y in (60, 30, 0, -30):
        shade = SIGHT if y == 30 else FAINT
        s.line([(0, y + 3), (part, y + 1.5)], shade, 1)
        s.line([(0, y - 3), (part, y - 1.5)], shade, 1)
    s.area([(part, -80), (part + 26, -66), (part + 26, 80), (part, 80)], "#d5e2f6", HUES[0], 0.6)
    s.text((part + 13, 96), "part")
    s.ray([(part + 26, 30), (lens, 62)], SIGHT, 1.4)
    s.ray([(lens, 62), (plane, 32)], SIGHT, 1.4)
    s.line([(part + 26, 0), (lens, 0)], FAINT, 1)
    s.line([(lens, 0), (plane, 0)], FAINT, 1)
    s.lens(lens, 92)
    for k in range(-2, 2):
        low = 24 * k + 12
        hue = SIGHT if k == 1 else INK
        s.area([(plane, low), (plane + 9, low), (plane + 9, low + 22), (plane, low + 22)], "none", hue)
    s.text((plane + 16, 36), "one direction", "start", SIGHT)
    s.text((plane + 16, -20), "J × K detectors", "start")
    s.dimension((0, -70), (part + 13, -70), "`workingDistance` z_w", -26)
    s.dimension((-14, 30), (-14, 60), "", 0)
    s.text((-22, 41), "`pixelSize`", "end", DIM)
    s.text((512, 12), "z", "end", FAINT)
    return s


def laser_triangulation():
    s = Sketch(
        640,
        330,
        (250, 70),
        "Laser triangulation head: a laser above the part, and a camera aside whose tilted film, lens "
        "and plane of the light meet in one line",
    )
    top, angle, away = 210, 60, 170
    s.area([(-190, -30), (300, -30), (300, 0), (60, 0), (60, 26), (-40, 26), (-40, 0), (-190, 0)],
           GLASS, EDGE, 1, 0.8)
    s.text((250, -20), "part")
    s.line([(0, top), (0, 26)], LIGHT, 2)
    s.area([(-14, top), (14, top), (14, top + 24), (-14, top + 24)], PALE, INK)
    s.text((-22, top + 8), "`laser`", "end")
    eye = polar((0, 26), away, angle)
    across = (-math.sin(math.radians(angle)), math.cos(math.radians(angle)))
    s.line([(eye[0] - 34 * across[0], eye[1] - 34 * across[1]),
            (eye[0] + 34 * across[0], eye[1] + 34 * across[1])], EDGE, 3)
    s.ray([(0, 26), eye], SIGHT, 1.4)
    s.ray([(0, 0), eye], SIGHT, 0.8)
    # Scheimpflug: the film is on the line through its middle and the point where the plane of the
    # lens meets the light, (0, meet).
    film = polar(eye, 62, angle)
    meet = eye[1] - eye[0] * across[1] / across[0]
    lean = math.degrees(math.atan2(film[1] - meet, film[0]))
    s.line([polar(film, -30, lean), polar(film, 30, lean)], FILM, 4)
    s.line([eye, film], SIGHT, 1.4)
    steep = math.tan(math.radians(lean))
    lower = meet / (eye[1] / eye[0] - steep)  # where the ray from (0, 0) meets the film
    s.line([eye, (lower, lower * eye[1] / eye[0])], SIGHT, 0.8)
    for one in (eye, film):
        s.line([(0, meet), one], FAINT, 1, "6 4")
    s.text((film[0] + 44, film[1] - 6), "film, `tilt` τ", "start", FILM)
    s.text((eye[0] + 44, eye[1] - 22), "lens", "start")
    s.arc((0, 26), 74, angle, 90, DIM, 0.9)
    s.text((26, 112), "θ", "start", DIM)
    s.ray([(-120, -46), (-60, -46)], HUES[0], 1.8)
    s.text((-54, -50), "`feed`", "start", HUES[0])
    return s


DRAWINGS = {
    "pinhole": pinhole,
    "thin-lens": thin_lens,
    "telecentric": telecentric,
    "light-field": light_field,
    "line-scan": line_scan,
    "flying-spot": flying_spot,
    "laser-triangulation": laser_triangulation,
}

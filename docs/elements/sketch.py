# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of the drawings: axis, lens, stop, sensor plane, rays, dimension lines, labels.

A Sketch takes coordinates in pixels about an origin of its own, x to the right and y up, and
writes SVG. In a label, `key` is set as a key of the scene file and D_l as a D with the index l.
"""

import html
import math
import re

INK, FAINT, DIM = "#222222", "#8a8a8a", "#555555"
LIGHT, SIGHT = "#d07a00", "#c1272d"  # what an emitter sends; a camera ray
GLASS, EDGE, FILM, PALE = "#d9ecfa", "#2b7bb9", "#2c6e49", "#fdebc8"
HUES = ("#c1272d", "#d07a00", "#2c6e49", "#2b5fb9", "#7a3fa0")


def number(x):
    """Two decimals at most, without trailing zeros or a negative zero."""
    text = ("%.2f" % x).rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def polar(p, length, angle):
    """The point at this distance and angle [deg] from p."""
    return (p[0] + length * math.cos(math.radians(angle)),
            p[1] + length * math.sin(math.radians(angle)))


def between(p, q, t):
    return (p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t)


class Sketch:
    def __init__(self, width, height, origin, title):
        self.width, self.height, self.origin, self.title = width, height, origin, title
        self.parts = []

    # --- strokes and areas ----------------------------------------------------------------------

    def place(self, p):
        return number(self.origin[0] + p[0]), number(self.height - self.origin[1] - p[1])

    def points(self, points):
        return " ".join(",".join(self.place(p)) for p in points)

    def line(self, points, colour=INK, width=1.4, dash=None):
        self.parts.append('<polyline points="%s" fill="none" stroke="%s" stroke-width="%s"%s/>' %
                          (self.points(points), colour, number(width),
                           ' stroke-dasharray="%s"' % dash if dash else ""))

    def area(self, points, fill, stroke="none", opacity=1, width=1.4):
        self.parts.append('<polygon points="%s" fill="%s" stroke="%s" stroke-width="%s"%s/>' %
                          (self.points(points), fill, stroke, number(width),
                           ' fill-opacity="%s"' % number(opacity) if opacity < 1 else ""))

    def arc(self, centre, radius, first, last, colour=INK, width=1.4, dash=None):
        steps = max(4, int(abs(last - first) / 3))
        self.line([polar(centre, radius, first + (last - first) * i / steps)
                   for i in range(steps + 1)], colour, width, dash)

    def circle(self, centre, radius, fill="none", stroke=INK, width=1.4, dash=None):
        x, y = self.place(centre)
        self.parts.append('<circle cx="%s" cy="%s" r="%s" fill="%s" stroke="%s" stroke-width="%s"'
                          '%s/>' % (x, y, number(radius), fill, stroke, number(width),
                                    ' stroke-dasharray="%s"' % dash if dash else ""))

    def head(self, tip, angle, colour, size=8):
        self.area([tip, polar(tip, size, angle + 160), polar(tip, size, angle - 160)], colour)

    def arrow(self, p, q, colour=INK, width=1.4, dash=None, at=1):
        """A straight arrow; `at` says where on its way the head is."""
        self.line([p, q], colour, width, dash)
        angle = math.degrees(math.atan2(q[1] - p[1], q[0] - p[0]))
        self.head(between(p, q, at), angle, colour)

    def ray(self, points, colour=LIGHT, width=1.4, dash=None, heads=True):
        """A path through these points, with a head on each of its pieces that is long enough."""
        self.line(points, colour, width, dash)
        for p, q in zip(points, points[1:]):
            length = math.hypot(q[0] - p[0], q[1] - p[1])
            if heads and length > 30:
                angle = math.degrees(math.atan2(q[1] - p[1], q[0] - p[0]))
                self.head(between(p, q, 0.5 + 4 / length), angle, colour, 7)

    def lobe(self, p, normal, length, shape, fill=PALE, stroke=LIGHT, span=90):
        """How much goes in which direction: length · shape(angle from the normal [deg])."""
        steps = range(-2 * span, 2 * span + 1)
        self.area([p] + [polar(p, length * shape(k / 2), normal + k / 2) for k in steps], fill,
                  stroke, 0.8, 1)

    # --- optics -------------------------------------------------------------------------------

    def axis(self, first, last, y=0):
        self.line([(first, y), (last, y)], FAINT, 1, "12 4 2 4")

    def lens(self, x, half, bulge=9, y=0):
        """A thin lens: two arcs that meet at its rim."""
        radius = (half * half + bulge * bulge) / (2 * bulge)
        angles = [math.asin(half / radius) * k / 12 for k in range(-12, 13)]
        right = [(x + radius * math.cos(a) - radius + bulge, y + radius * math.sin(a))
                 for a in angles]
        self.area(right + [(2 * x - p[0], p[1]) for p in reversed(right)], GLASS, EDGE, 0.8)

    def stop(self, x, opening, outer, y=0):
        for sign in (1, -1):
            self.line([(x, y + sign * opening), (x, y + sign * outer)], INK, 3.5)

    def film(self, x, low, high, pixels=0, depth=7):
        """A sensor plane seen from the side, its pixels behind it."""
        self.area([(x, low), (x, high), (x - depth, high), (x - depth, low)], "#cfe8d8", FILM)
        for i in range(1, pixels):
            y = low + (high - low) * i / pixels
            self.line([(x, y), (x - depth, y)], FILM, 1)

    def panel(self, p, q, depth=7, fill=PALE, stroke=LIGHT):
        """A surface that emits, from p to q; its back lies to the right of who goes there."""
        length = math.hypot(q[0] - p[0], q[1] - p[1])
        back = ((q[1] - p[1]) * depth / length, (p[0] - q[0]) * depth / length)
        self.area([p, q, (q[0] + back[0], q[1] + back[1]), (p[0] + back[0], p[1] + back[1])],
                  fill, stroke)

    def wall(self, p, q, depth=9, colour=INK):
        """An opaque surface from p to q, hatched to the right of who goes there."""
        self.line([p, q], colour, 2)
        length = math.hypot(q[0] - p[0], q[1] - p[1])
        u = ((q[0] - p[0]) / length, (q[1] - p[1]) / length)
        for i in range(int(length / 8)):
            a = (p[0] + u[0] * (8 * i + 8), p[1] + u[1] * (8 * i + 8))
            b = (a[0] + depth * (u[1] - u[0]) * 0.7, a[1] + depth * (-u[0] - u[1]) * 0.7)
            self.line([a, b], FAINT, 1)

    # --- words and dimensions -------------------------------------------------------------------

    def text(self, p, words, anchor="middle", colour=INK, size=13):
        x, y = self.place((p[0], p[1] - 0.35 * size))
        self.parts.append('<text x="%s" y="%s" text-anchor="%s" fill="%s" font-size="%d">%s</text>'
                          % (x, y, anchor, colour, size, markup(words)))

    def dot(self, p, words="", towards=45, colour=INK, gap=10):
        self.circle(p, 2.6, colour, colour)
        if words:
            at = polar(p, gap, towards)
            side = math.cos(math.radians(towards))
            self.text(at, words, "start" if side > 0.3 else "end" if side < -0.3 else "middle",
                      colour)

    def dimension(self, p, q, words, off=0, gap=9, anchor=None, at=0.5):
        """From p to q, drawn `off` to the left of who goes there; the words stand beside it."""
        length = math.hypot(q[0] - p[0], q[1] - p[1])
        left = ((p[1] - q[1]) / length, (q[0] - p[0]) / length)
        a, b = ((c[0] + off * left[0], c[1] + off * left[1]) for c in (p, q))
        for c, d in ((p, a), (q, b)):
            if off:
                over = off + math.copysign(4, off)
                self.line([(c[0] + left[0] * 3 * math.copysign(1, off),
                            c[1] + left[1] * 3 * math.copysign(1, off)),
                           (c[0] + over * left[0], c[1] + over * left[1])], DIM, 0.7)
        self.line([a, b], DIM, 0.9)
        angle = math.degrees(math.atan2(b[1] - a[1], b[0] - a[0]))
        self.head(b, angle, DIM, 7)
        self.head(a, angle + 180, DIM, 7)
        side = math.copysign(1, off) if off else 1
        middle = between(a, b, at)
        upright = abs(left[0]) > 0.5
        spot = (middle[0] + side * gap * left[0], middle[1] + side * gap * left[1])
        if anchor is None:
            anchor = ("start" if side * left[0] > 0 else "end") if upright else "middle"
        self.text(spot, words, anchor, DIM)

    def angle(self, centre, radius, first, last, words, gap=12, towards=None):
        """An arc between two directions [deg] with the name of the angle beside its middle."""
        self.arc(centre, radius, first, last, DIM, 0.9)
        middle = (first + last) / 2 if towards is None else towards
        at = polar(centre, radius + gap, middle)
        side = math.cos(math.radians(middle))
        self.text(at, words, "start" if side > 0.5 else "end" if side < -0.5 else "middle", DIM)

    def svg(self):
        return "\n".join([
            '<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" viewBox="0 0 %d %d"'
            ' role="img">' % (self.width, self.height, self.width, self.height),
            "<title>%s</title>" % html.escape(self.title),
            '<rect width="%d" height="%d" fill="#ffffff"/>' % (self.width, self.height),
            '<g font-family="DejaVu Sans, Verdana, Arial, sans-serif" stroke-linejoin="round">',
            "<style>text{paint-order:stroke;stroke:#fff;stroke-width:4px}</style>",
            *self.parts, "</g>", "</svg>", ""])


def markup(words):
    """`key` in the typeface of code, X_i with an index."""
    pieces = []
    for i, piece in enumerate(words.split("`")):
        piece = html.escape(piece, quote=False)
        if i % 2:
            piece = '<tspan font-family="DejaVu Sans Mono, Consolas, monospace" font-size="12">' \
                    "%s</tspan>" % piece
        else:
            piece = re.sub(r"_(\w)", r'<tspan dy="3" font-size="9">\1</tspan>'
                           '<tspan dy="-3">\u200b</tspan>', piece)
        pieces.append(piece)
    return "".join(pieces)

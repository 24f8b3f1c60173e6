# SPDX-License-Identifier: Apache-2.0
"""Measured values: a number, its standard uncertainty and its unit."""

from __future__ import annotations

import html
import math
from typing import Any, Dict, Iterator, List, Mapping, Optional, Union

from mcvisi.errors import UsageError, unknown_name

# How a length is shown, from the first that is not larger than it; the others are for to().
_LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9, "cm": 1e-2, "inch": 0.0254}
_SHOWN_LENGTHS = (("m", 10.0), ("mm", 1e-4), ("µm", 1e-7), ("nm", 0.0))
_UNITS: Mapping[str, Mapping[str, float]] = {
    "m": _LENGTHS,
    "rad": {"rad": 1.0, "deg": math.pi / 180, "°": math.pi / 180, "mrad": 1e-3},
}

# The units of figures in pixels, of angles and of ratios; the others have the image's.
_PIXELS = (
    "position column row radius diameter width width_10_90 sagitta straightness roundness distance "
    "line_distance"
).split()
_FIGURE_UNITS = {
    **{name: "px" for name in _PIXELS},
    **{name: "rad" for name in ("tilt", "angle")},
    **{name: "1/px" for name in ("mtf50",)},
    **{
        name: ""
        for name in (
            "snr rms_contrast uniformity weber_contrast michelson_contrast contrast_to_noise "
            "mtf_at_nyquist"
        ).split()
    },
}


def figure_unit(name: str, image_unit: str) -> str:
    """The unit of a figure of a measurement."""
    if name == "length" or name.endswith("_length"):
        return "m"
    return _FIGURE_UNITS.get(name, image_unit)


def unit_of(told: str) -> str:
    """A unit as this package writes it."""
    return {"pixels": "px", "cycles/pixel": "1/px"}.get(told, told)


def value_text(value: float, uncertainty: float) -> str:
    """12.3456(21): the uncertainty in two digits, of the last places of the value."""
    if not (math.isfinite(value) and math.isfinite(uncertainty)) or uncertainty <= 0:
        return "%.6g" % value
    last = math.floor(math.log10(uncertainty)) - 1
    digits = round(uncertainty / 10.0**last)
    if digits == 100:
        last, digits = last + 1, 10
    if last > 0:
        return "%.0f(%.0f)" % (round(value, -last), digits * 10.0**last)
    if last <= -12:
        return "%.6g ± %.2g" % (value, uncertainty)
    shown = str(digits) if last < -1 or digits < 10 else "%.*f" % (-last, digits * 10.0**last)
    return "%.*f(%s)" % (-last, value, shown)


class Value:
    """
    A measured value: value and standard uncertainty in the unit, which is of the SI, "px" or the
    image's. Shown as 12.3456(21) mm. float() is the value, and a format such as "{:.3g}" its own.
    """

    __slots__ = ("value", "uncertainty", "unit")

    def __init__(self, value: float, uncertainty: float, unit: str = "") -> None:
        self.value, self.uncertainty, self.unit = value, uncertainty, unit

    def __float__(self) -> float:
        return self.value

    def __format__(self, words: str) -> str:
        return format(self.value, words) if words else str(self)

    def to(self, unit: str) -> "Value":
        """The same in another unit: value.to("mm"), angle.to("deg")."""
        known = _UNITS.get(self.unit, {self.unit: 1.0})
        if not isinstance(unit, str) or unit not in known:
            raise UsageError(
                "a value in %r is not known in %r; there are %s"
                % (self.unit, unit, ", ".join(known))
            )
        return Value(self.value / known[unit], self.uncertainty / known[unit], unit)

    def _shown(self) -> "Value":
        if self.unit == "m":
            return self.to(next(u for u, least in _SHOWN_LENGTHS if abs(self.value) >= least))
        return self.to("deg") if self.unit == "rad" else self

    def __str__(self) -> str:
        shown = self._shown()
        return ("%s %s" % (value_text(shown.value, shown.uncertainty), shown.unit)).rstrip()

    def __repr__(self) -> str:
        return "Value(%r, %r, %r)" % (self.value, self.uncertainty, self.unit)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Value):
            return NotImplemented
        return (self.value, self.uncertainty, self.unit) == (
            other.value,
            other.uncertainty,
            other.unit,
        )

    def __hash__(self) -> int:
        return hash((self.value, self.uncertainty, self.unit))


class Figures:
    """
    What was measured at one place: its figures are attributes, such as edges["right"].length. All
    that the report says of it is in `report`.
    """

    def __init__(self, report: Dict[str, Any], image_unit: str) -> None:
        self.report = report
        self._unit = image_unit

    @property
    def name(self) -> str:
        """The name that the place was given."""
        return str(self.report["name"])

    @property
    def type(self) -> str:
        """ "region", "edge", "line", "caliper", "circle" or "arc"."""
        return str(self.report["type"])

    def _figure(self, name: str) -> Any:
        found = self.report[name]
        if isinstance(found, dict) and "value" in found:
            # null stands for what is not finite.
            value, known = (
                math.nan if found.get(key) is None else found[key]
                for key in ("value", "uncertainty")
            )
            return Value(value, known, figure_unit(name, self._unit))
        return found

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        # An edge's position is its column or its row.
        for key in (name, "column", "row") if name == "position" else (name,):
            if key in self.report:
                return self._figure(key)
        why = next((w for k, w in self.report.items() if k.startswith("no_")), "")
        raise AttributeError(
            "%s %s has no %r%s; it has %s"
            % (self.type, self.name, name, " (%s)" % why if why else "", ", ".join(self))
        )

    def __iter__(self) -> Iterator[str]:
        return (key for key, value in self.report.items() if isinstance(value, dict))

    def __dir__(self) -> List[str]:
        return [*object.__dir__(self), *self]

    def __repr__(self) -> str:
        words = ("%s %s" % (key, self._figure(key)) for key in self)
        return "<%s %s: %s>" % (self.type, self.name, ", ".join(words))


_LISTS = ("regions", "edges", "lines", "calipers", "circles", "arcs")


class Measurement(Mapping[str, Figures]):
    """
    The places measured, by name. Distances from the first edge, line or circle stand with the place
    that they lead to: result["right"].length. report: the program's JSON.
    """

    def __init__(self, report: Mapping[str, Any], image_unit: str) -> None:
        self.report = report
        self._figures: Dict[str, Figures] = {}
        for kind in _LISTS:
            for item in report.get(kind, ()):
                self._figures[item["name"]] = Figures(dict(item), image_unit)
        for item in report.get("distances", ()):
            self._add_distance(item)

    def _add_distance(self, item: Mapping[str, Any]) -> None:
        """The report names it "left to right"."""
        target: Optional[Figures] = None
        for start in self._figures:
            if item["name"].startswith(start + " to "):
                target = self._figures.get(item["name"][len(start) + 4 :], target)
        if target is not None:
            found = {key: value for key, value in item.items() if key not in ("name", "type")}
            for key, value in found.items():
                target.report.setdefault(key, value)

    def __getitem__(self, name: str) -> Figures:
        if name not in self._figures:
            raise unknown_name("this measurement", name, self)
        return self._figures[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)

    def _ipython_key_completions_(self) -> List[str]:
        return list(self)

    def __repr__(self) -> str:
        return "\n".join(map(repr, self._figures.values()))

    def _repr_html_(self) -> str:
        rows = []
        for figures in self._figures.values():
            for key in figures:
                cells: Union[Any] = (figures.type, figures.name, key, str(figures._figure(key)))
                rows.append("<tr>%s</tr>" % "".join("<td>%s</td>" % html.escape(c) for c in cells))
        return "<table>%s</table>" % "".join(rows)

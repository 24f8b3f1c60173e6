# SPDX-License-Identifier: Apache-2.0
"""Options as Python has them, in the words of the library: the JSON of a verb's options."""

from __future__ import annotations

import json
import operator
import os
from typing import Any, List, Mapping, Sequence, Tuple, Union

from mcvisi.errors import BadInput, UsageError

# A number in SI units, or a text with a unit: "10ms".
Quantity = Union[float, str]
# One, or one each of red, green and blue.
Quantities = Union[Quantity, Sequence[Quantity]]
Size = Union[Tuple[int, int], str]
# A rectangle (x, y, width, height) in pixels, a polygon (x, y, x, y, …), or a text as on the
# command line: "@part:-30mm,0mm,3mm,3mm,10mm".
Box = Union[Sequence[float], str]
Boxes = Union[Mapping[str, Box], Sequence[str], str]
# Each line may have several boxes.
Lines = Union[Mapping[str, Union[Box, Sequence[Sequence[float]]]], Sequence[str], str]
# By name, or as on the command line.
Named = Union[Mapping[str, Quantity], Sequence[str], str]
Texts = Union[Sequence[str], str]
Path = Union[str, "os.PathLike[str]"]
Files = Union[Path, Sequence[Path]]
# A sweep's values of a parameter: a list, a range of mcvisi.linear or mcvisi.log, or a text.
Values = Union[Sequence[Quantity], str]

# How each option writes what is not a plain value.
_SIGNS = {"resolution": "x", "angular": "x", "samples": ":", "range": "/"}


def _plain(value: Any, name: str) -> Any:
    """A value that JSON has, from one of Python's or numpy's."""
    if hasattr(value, "item") and getattr(value, "shape", None) == ():
        value = value.item()
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise UsageError("%s: must be a number or a text, not %s" % (name, type(value).__name__))


def _text(value: Any, name: str) -> str:
    plain = _plain(value, name)
    return plain if isinstance(plain, str) else repr(plain)


def _is_list(value: Any) -> bool:
    return hasattr(value, "__iter__") and not isinstance(value, (str, bytes, Mapping))


def listed(value: Any) -> List[Any]:
    """One or several, as a list."""
    return list(value) if _is_list(value) else [value]


def joined(value: Any, name: str, sign: str = ",") -> str:
    """Several values as one text: (80, 300, 60, 80) is "80,300,60,80"."""
    return sign.join(_text(item, name) for item in value) if _is_list(value) else _text(value, name)


def _box(value: Any, name: str) -> str:
    """One box, or several of a line, joined by +."""
    if _is_list(value):
        items = list(value)
        if any(_is_list(item) for item in items):
            return "+".join(joined(item, name) for item in items)
        return joined(items, name)
    return _text(value, name)


def _named(values: Any, name: str, sign: str) -> List[str]:
    """A mapping as NAME=VALUE; a list, and one text, as on the command line."""
    if isinstance(values, Mapping):
        return ["%s%s%s" % (key, sign, _box(value, name)) for key, value in values.items()]
    if isinstance(values, str):
        return [values]
    if not _is_list(values):
        raise UsageError(
            "%s: must be a dictionary of names, a list of texts or a text, not %s"
            % (name, type(values).__name__)
        )
    return [_text(item, name) for item in values]


# Options that may be repeated: their name in Python, what stands behind the name of an item.
REPEATED = {
    "region": ("regions", "="),
    "edge": ("edges", "="),
    "line": ("lines", "="),
    "caliper": ("calipers", "="),
    "circle": ("circles", "="),
    "arc": ("arcs", "="),
    "metric": ("metrics", ":="),
    "tie": ("ties", "="),
    "where": ("where", "="),
    "until": ("until", "="),
    "vary": ("vary", "="),
    "tolerance": ("tolerance", "="),
    "objective": ("objectives", "="),
    "better": ("better", "="),
    "correlate": ("correlate", "="),
    "index": ("index", "="),
}


PLURALS = {option: name for option, (name, _) in REPEATED.items()}


def _value(option: str, value: Any) -> Any:
    name = PLURALS.get(option) or option.replace("-", "_")
    if option in REPEATED:
        return _named(value, name, REPEATED[option][1])
    if option in ("best", "bound") and isinstance(value, Mapping) and len(value) == 1:
        return _named(value, name, "=")[0]
    if option == "output" and _is_list(value):
        return [_plain(item, name) for item in value]
    if option == "pod" and isinstance(value, Mapping):
        return json.loads(options_json(value))
    if option in _SIGNS:
        return joined(value, name, _SIGNS[option])
    if _is_list(value):
        return joined(value, name)
    return _plain(value, name)


def _jsonable(value: Any) -> Any:
    """numpy's numbers and arrays as Python's."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError


def value_json(path: str, value: Any) -> bytes:
    """The JSON of a value of a scene."""
    try:
        return json.dumps(value, default=_jsonable, allow_nan=False).encode()
    except (TypeError, RecursionError):
        raise UsageError(
            "%s: a scene has numbers, texts, lists and dictionaries, not %s"
            % (path, type(value).__name__)
        ) from None
    except ValueError:
        raise BadInput("%s: must be a finite number" % path) from None


def options_json(options: Mapping[str, Any]) -> bytes:
    """The JSON that the library takes; None leaves an option out."""
    words = {name: _value(name, value) for name, value in options.items() if value is not None}
    try:
        return json.dumps(words, allow_nan=False).encode()
    except ValueError:
        wrong = [
            name for name, value in words.items() if value != value or value in (1e999, -1e999)
        ]
        raise UsageError("%s: must be a finite number" % ", ".join(wrong)) from None


def linear(first: Quantity, last: Quantity, count: int) -> str:
    """`count` values from first to last, evenly spaced: what a sweep varies."""
    try:
        return "%s..%s:%d" % (_text(first, "first"), _text(last, "last"), operator.index(count))
    except TypeError:
        raise UsageError("count: must be a whole number, not %s" % type(count).__name__) from None


def log(first: Quantity, last: Quantity, count: int) -> str:
    """`count` values from first to last, each the same multiple of the one before."""
    return linear(first, last, count) + ":log"

# SPDX-License-Identifier: Apache-2.0
"""The probability of detection."""

from __future__ import annotations

from typing import Any, Mapping

from mcvisi.errors import UsageError
from mcvisi.library import ffi, json_of, path_bytes
from mcvisi.options import Path, options_json


def table_report(table: Path, options: Mapping[str, Any]) -> Mapping[str, Any]:
    """The report of a table."""
    found: Mapping[str, Any] = json_of(
        "mcv_pod_table", path_bytes(table, "table"), options_json(options)
    )
    return found


def _numbers(values: Any, what: str) -> Any:
    import numpy

    try:
        numbers = numpy.ascontiguousarray(values, dtype=float)
    except (TypeError, ValueError):
        raise UsageError("%s: must be an array of numbers" % what) from None
    if numbers.ndim != 1:
        raise UsageError("%s: must have one dimension, not %d" % (what, numbers.ndim))
    return numbers


def values_report(
    sizes: Any, values: Any, hits: bool, options: Mapping[str, Any]
) -> Mapping[str, Any]:
    """The report of arrays."""
    x, y = _numbers(sizes, "sizes"), _numbers(values, "values")
    if len(x) != len(y):
        raise UsageError("values: has %d numbers: must have %d, as sizes" % (len(y), len(x)))
    found: Mapping[str, Any] = json_of(
        "mcv_pod_values",
        ffi.from_buffer("double[]", x),
        ffi.from_buffer("double[]", y),
        len(x),
        bool(hits),
        options_json(options),
    )
    return found

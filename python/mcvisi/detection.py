# SPDX-License-Identifier: Apache-2.0
"""The probability of detection."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Mapping

from mcvisi.errors import Error, UsageError
from mcvisi.library import ffi, json_of, path_bytes
from mcvisi.options import Path, options_json
from mcvisi.sweep import Sweep

if TYPE_CHECKING:
    from mcvisi.rig import Rig
    from mcvisi.session import Session


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


def _truth(value: Any, what: str) -> bool:
    if getattr(value, "shape", ()) != ():
        raise UsageError("%s: must be True or False" % what)
    return bool(value)


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
        _truth(hits, "hits"),
        options_json(options),
    )
    return found


class Detection(Sweep):
    """
    A study of the probability of detection. Its rows are the sets that were rendered, as a
    sweep's are; answer is what they say, and waits for the end; report is then the whole of it.
    """

    _function = "mcv_session_pod"
    _grid = False

    def __init__(
        self,
        rig: "Rig",
        session: "Session",
        vary: Any,
        study: Any,
        progress: Any,
        options: Mapping[str, Any],
    ) -> None:
        if not isinstance(study, Mapping):
            raise UsageError('study: must be a dictionary, as in {"size": "depth", "hit": "found"}')
        super().__init__(rig, session, vary, progress, options)
        self._options["pod"] = {"output": self._page(), **study}
        self._words = session._options(self._options)

    def _page(self) -> str:
        return os.path.splitext(str(self._options["output"]))[0] + "-pod.html"

    @property
    def answer(self) -> str:
        """From which size on defects are found, in a sentence; waits for the end."""
        found = self._result()
        if "answer" not in found:
            raise Error("the study was ended before its last set: there is no answer")
        return str(found["answer"])

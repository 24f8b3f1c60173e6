# SPDX-License-Identifier: Apache-2.0
"""The search for the best parameters of a rig."""

from __future__ import annotations

from typing import Any, List, Mapping

from mcvisi.sweep import Sweep


class Optimization(Sweep):
    """
    A search. Its rows are the sets that were rendered, as a sweep's are; winner and front are the
    result, and wait for the end.
    """

    _function = "mcv_session_optimize"
    _grid = False

    @property
    def winner(self) -> Mapping[str, Any]:
        """
        Of one objective: "parameters" in SI units, "objectives" with "value" and "uncertainty",
        the 95 % "interval", what the search had seen ("in_search"), and "as_good_within".
        """
        found: Mapping[str, Any] = self._result().get("winner", {})
        return found

    @property
    def front(self) -> List[Mapping[str, Any]]:
        """Of several objectives: points of which none is better in all."""
        found: List[Mapping[str, Any]] = self._result().get("front", [])
        return found

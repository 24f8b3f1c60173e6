# SPDX-License-Identifier: Apache-2.0
"""How tolerances of parameters spread what is measured."""

from __future__ import annotations

from typing import Any, Mapping

from mcvisi.sweep import Sweep


class Uncertainty(Sweep):
    """
    A study of tolerances. Its rows are the sets that were rendered, as a sweep's are; metrics is
    what they say, and waits for the end.
    """

    _function = "mcv_session_uncertainty"
    _option = "tolerance"
    _grid = False

    @property
    def metrics(self) -> Mapping[str, Any]:
        """
        By name: "first_order" and "monte_carlo", each with its "uncertainty", a "value" and its
        95 % "interval"; "nonlinear"; and "effects", a list with the largest contribution first.
        Numbers are in SI units.
        """
        found: Mapping[str, Any] = self._result().get("metrics", {})
        return found

# SPDX-License-Identifier: Apache-2.0
"""What check() finds: sentences, and what was understood of the scene."""

from __future__ import annotations

import html
from typing import Any, List, Mapping


class Finding:
    """A sentence about a scene. severity: "error", "warning" or "note"; path: where it is."""

    def __init__(self, severity: str, path: str, text: str) -> None:
        self.severity, self.path, self.text = severity, path, text

    def __str__(self) -> str:
        return "%s: %s" % (self.severity, self.text)

    def __repr__(self) -> str:
        return "Finding(%r, %r, %r)" % (self.severity, self.path, self.text)


class Findings(List[Finding]):
    """The findings of a scene. report: all that was understood of it, in SI units."""

    def __init__(self, report: Mapping[str, Any]) -> None:
        # `strict` finds what is wrong with the file, and looks at nothing else.
        super().__init__(Finding("error", f["path"], f["text"]) for f in report.get("strict", ()))
        self += (
            Finding(f["severity"], f.get("path") or "", f["text"])
            for f in report.get("findings", ())
        )
        self.report = report

    @property
    def errors(self) -> List[Finding]:
        """Those that make the picture worthless."""
        return [finding for finding in self if finding.severity == "error"]

    def _repr_html_(self) -> str:
        if not self:
            return "<p>no findings</p>"
        row = "<tr><td>%s</td><td><code>%s</code></td><td>%s</td></tr>"
        cells = (tuple(map(html.escape, (f.severity, f.path, f.text))) for f in self)
        return "<table>%s</table>" % "".join(row % c for c in cells)

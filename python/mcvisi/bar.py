# SPDX-License-Identifier: Apache-2.0
"""The progress bar of a render or a sweep: in a terminal, or in a notebook."""

from __future__ import annotations

import math
import sys
from typing import Any, Callable, Optional, Union

from mcvisi.errors import UsageError
from mcvisi.session import Progress, ProgressOption

# A render shorter than this shows none [s].
_PATIENCE = 0.5
_WIDTH = 30


class SetsDone:
    """How far a sweep is: of how many sets is known with the first."""

    def __init__(self, done: int, sets: int, seconds: float) -> None:
        self.done, self.sets, self.seconds = done, sets, seconds
        self.fraction = done / sets if sets else 0.0


Shown = Union[Progress, SetsDone]


def _words(progress: Shown) -> str:
    if isinstance(progress, SetsDone):
        of = " of %d" % progress.sets if progress.sets else ""
        return "%d%s sets, %.0f s" % (progress.done, of, progress.seconds)
    if math.isnan(progress.fraction):
        return "compiling kernels, %.0f s" % progress.seconds
    error = ", error %.2g" % progress.error if math.isfinite(progress.error) else ""
    return "%3.0f %%, %.0f s%s" % (100 * progress.fraction, progress.seconds, error)


def _share(progress: Shown) -> float:
    return 0.0 if math.isnan(progress.fraction) else min(max(progress.fraction, 0.0), 1.0)


class TerminalBar:
    """A line of the terminal that is written again and again, and wiped at the end."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._shown = False

    def __call__(self, progress: Shown) -> None:
        if progress.seconds < _PATIENCE:
            return
        done = round(_WIDTH * _share(progress))
        bar = "#" * done + "." * (_WIDTH - done)
        self._stream.write("\r\x1b[K%s %s" % (bar, _words(progress)))
        self._stream.flush()
        self._shown = True

    def pause(self) -> None:
        """Others may print."""
        if self._shown:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
        self._shown = False

    close = pause


class NotebookBar:
    """A progress element below the cell, which goes when the render ends."""

    def __init__(self, display: Callable[..., Any]) -> None:
        self._display = display
        self._handle: Any = None

    def __call__(self, progress: Shown) -> None:
        if progress.seconds < _PATIENCE:
            return
        html = '<progress value="%.3f"></progress> %s' % (_share(progress), _words(progress))
        data = {"text/html": html, "text/plain": _words(progress)}
        if self._handle is None:
            self._handle = self._display(data, raw=True, display_id=True)
        else:
            self._handle.update(data, raw=True)

    def pause(self) -> None:
        """It stays where it is."""

    def close(self) -> None:
        if self._handle is not None:
            self._handle.update({"text/plain": "", "text/html": ""}, raw=True)


def _in_notebook() -> bool:
    """Only what has been imported already is asked."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")


class Bar:
    """What the option `progress` asks for, as a context: a function, or None for nothing."""

    def __init__(self, option: ProgressOption) -> None:
        self._bar: Any = None
        self._told: Optional[Callable[[Progress], Optional[bool]]] = None
        if callable(option):
            self._told = option
        elif option is None:
            self._told = self._bar = self._usual()
        elif option is not False:
            raise UsageError("progress: must be None, False or a function")

    @staticmethod
    def of_sweep(option: Any) -> Any:
        """The bar of a sweep, or None for nothing."""
        if option is not None and option is not False:
            raise UsageError("progress: must be None or False: loop over the sweep for more")
        return None if option is False else Bar._usual()

    @staticmethod
    def _usual() -> Any:
        if _in_notebook():
            from IPython.display import display

            return NotebookBar(display)
        stream = sys.stderr
        return TerminalBar(stream) if stream is not None and stream.isatty() else None

    def __enter__(self) -> Optional[Callable[[Progress], Optional[bool]]]:
        return self._told

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

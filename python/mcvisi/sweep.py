# SPDX-License-Identifier: Apache-2.0
"""Sweeps: many sets of parameters, rendered and measured; rows as they finish."""

from __future__ import annotations

import html
import json
import os
import threading
import time
import weakref
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional

from mcvisi.bar import Bar, SetsDone
from mcvisi.errors import Error, UsageError, unknown_name
from mcvisi.library import call, ffi, json_of, path_bytes, take_text
from mcvisi.measurement import Value, unit_of
from mcvisi.options import Path, joined, listed, options_json
from mcvisi.work import Job

if TYPE_CHECKING:
    import pandas
    import xarray

    from mcvisi.rig import Rig
    from mcvisi.session import Session


class Row(Mapping[str, Any]):
    """
    One set: its parameters as numbers in SI units or texts, and its metrics as values with their
    uncertainty. message: why the set failed, or None; then it has no metrics.
    """

    def __init__(self, report: Mapping[str, Any]) -> None:
        self.report = report
        self.parameters: Mapping[str, Any] = report["parameters"]
        self.metrics: Mapping[str, Value] = {
            name: Value(found["value"], found["uncertainty"], unit_of(found.get("unit", "")))
            for name, found in (report.get("metrics") or {}).items()
            if found is not None and found.get("value") is not None
        }
        self.message: Optional[str] = report.get("message") or None

    def __getitem__(self, name: str) -> Any:
        for found in (self.metrics, self.parameters):
            if name in found:
                return found[name]
        raise unknown_name("this set", name, self)

    def __iter__(self) -> Iterator[str]:
        yield from self.parameters
        yield from self.metrics

    def __len__(self) -> int:
        return len(self.parameters) + len(self.metrics)

    def __repr__(self) -> str:
        words = ["%s=%s" % (name, self[name]) for name in self]
        return "<Row %s>" % ", ".join(words + ([self.message] if self.message else []))


def _vary(values: Any, option: str) -> List[str]:
    if not isinstance(values, Mapping):
        raise UsageError("%s: must be a dictionary of paths and their values" % option)
    return ["%s=%s" % (path, joined(v, path)) for path, v in values.items()]


class Sweep:
    """
    A sweep of a rig as it was when sweep() was called. It begins when it is first looked at.

    `for row in sweep` gives the rows as they finish. Leaving the loop, or Ctrl-C, ends the sweep
    and keeps the rows so far; they come first when it is looped over again. rows, to_pandas() and
    to_xarray() wait for the end.
    """

    #: The library's function, the option of the parameters, and whether they make a grid.
    _function = "mcv_session_sweep"
    _option = "vary"
    _grid = True

    def __init__(
        self,
        rig: "Rig",
        session: "Session",
        vary: Any,
        progress: Any,
        options: Mapping[str, Any],
    ) -> None:
        self._bar = Bar.of_sweep(progress)
        self._begun = 0.0
        self._session = session
        self._rig = rig._snapshot()
        self._vary = _vary(vary, self._option)
        self._options = {**options, self._option: self._vary}
        self._rows: List[Row] = []
        self._job: Optional[Job] = None
        self._ended = False
        self._failure: Optional[BaseException] = None
        self._lock = threading.Lock()
        #: What is odd in the scene, in sentences.
        self.notes: List[str] = []
        #: The summary of the sweep, once it has ended.
        self.report: Mapping[str, Any] = {}
        if self._options.get("output") is None:
            import shutil
            import tempfile

            # The page that a notebook shows; its folder goes with this object.
            folder = tempfile.mkdtemp(prefix="mcvisi-")
            weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
            self._options["output"] = os.path.join(folder, "sweep.csv")
        self._words = session._options(self._options)

    def _work(self, job: Job) -> Mapping[str, Any]:
        def told(_user: Any, row: Any) -> bool:
            if job.stopped:
                return False
            found = json.loads(ffi.string(row).decode()) if row != ffi.NULL else {}
            self.notes += [note["text"] for note in found.get("notes", ())]
            if "set" in found:
                job.tell(Row(found))
            elif self._bar is not None:
                job.tell(None)  # nothing new, but that time goes by
            return not job.stopped

        report, error = ffi.new("char **"), ffi.new("mcv_error *")
        callback = ffi.callback("mcv_told_call", told, error=False)
        try:
            call(
                self._function,
                self._session._get(),
                self._rig,
                self._words,
                callback,
                ffi.NULL,
                report,
            )
        except Error as failure:
            if not job.stopped or failure.code != 130:
                take_text(report)  # there is one where all sets failed
                raise
        words = take_text(report)
        found: Mapping[str, Any] = json.loads(words) if words else {}
        return found

    def __iter__(self) -> Iterator[Row]:
        at = 0
        while at < len(self._rows) or self._advance():
            at += 1
            try:
                yield self._rows[at - 1]
            except GeneratorExit:
                self.stop()
                raise

    def _advance(self) -> bool:
        """Waits for a row; False at the end."""
        with self._lock:
            # After a failure the rows are what there is. list() hides a TypeError of __len__.
            if self._failure is not None and (
                not self._rows or isinstance(self._failure, TypeError)
            ):
                raise self._failure
            if self._ended:
                return False
            if self._job is None:
                self._begun = time.monotonic()
                self._job = self._session._begin(self._work)
            try:
                more, item = self._next(self._job)
            except KeyboardInterrupt:
                self._stop()
                raise
            except BaseException as failure:
                self._ended, self._failure = True, failure
                raise
            if more:
                self._rows.append(item)
            else:
                self.report, self._ended = item, True
            return more

    def _next(self, job: Job) -> "tuple[bool, Any]":
        """What comes next, with the bar while it does not."""
        more, item = False, None
        try:
            while True:
                more, item = job.next()
                if not more or item is not None:
                    return more, item
                sets = self._rows[0].report["sets"] if self._rows else 0
                self._bar(SetsDone(len(self._rows), sets, time.monotonic() - self._begun))
        finally:
            if self._bar is not None:
                self._bar.pause() if more else self._bar.close()

    def _keep(self, row: Optional[Row]) -> None:
        if row is not None:
            self._rows.append(row)

    def _stop(self) -> None:
        if self._job is not None and not self._ended:
            self._job.stop()
            self._ended = True
            try:
                self.report = self._job.wait(self._keep)
            except Error as failure:
                self._failure = failure  # told to who asks for the result

    def stop(self) -> None:
        """Ends the sweep within the set that is rendered; the rows so far stay."""
        if self._job is not None:
            self._job.stop()  # before the lock: another thread may wait for a row with it
        with self._lock:
            self._stop()
            self._ended = True

    @property
    def finished(self) -> bool:
        """Whether it has ended: all rows are there, or it was stopped."""
        return self._ended

    @property
    def rows(self) -> List[Row]:
        """All rows; waits for the end."""
        self._end()
        return list(self._rows)

    def _end(self) -> None:
        """Waits for the end."""
        while self._advance():
            pass

    def _result(self) -> Mapping[str, Any]:
        """The report, or why there is none; waits for the end."""
        self._end()
        if self._failure is not None:
            raise self._failure
        return self.report

    def __len__(self) -> int:
        return len(self.rows)

    def __reduce__(self) -> Any:
        raise UsageError("a sweep cannot be copied or pickled: keep its to_pandas()")

    def __repr__(self) -> str:
        state = "ended" if self._ended else "not begun" if self._job is None else "running"
        return "<mcvisi.%s of %s; %s, %d rows>" % (
            type(self).__name__,
            ", ".join(self._vary),
            state,
            len(self._rows),
        )

    # Tables.

    def _columns(self) -> Dict[str, List[Any]]:
        rows = self.rows
        columns: Dict[str, List[Any]] = {}
        for name in dict.fromkeys(n for row in rows for n in row.parameters):
            columns[name] = [row.parameters.get(name) for row in rows]
        for name in dict.fromkeys(n for row in rows for n in row.metrics):
            found = [row.metrics.get(name) for row in rows]
            columns[name] = [float("nan") if v is None else v.value for v in found]
            columns[name + "_u"] = [float("nan") if v is None else v.uncertainty for v in found]
        return columns

    def _units(self) -> Dict[str, str]:
        return {name: v.unit for row in self.rows for name, v in row.metrics.items()}

    def to_pandas(self) -> "pandas.DataFrame":
        """
        A row for each set: parameters, metrics, NAME_u for their uncertainties, message. attrs: the
        units of the metrics.
        """
        import pandas

        frame = pandas.DataFrame(
            {**self._columns(), "message": [row.message or "" for row in self.rows]}
        )
        frame.attrs["units"] = self._units()
        return frame

    def to_xarray(self) -> "xarray.Dataset":
        """
        Metrics over the parameters: a dimension for each parameter of a grid, else one dimension
        `set`. NAME_u is the standard uncertainty of NAME. attrs: the paths of the parameters, the
        units of the metrics, and the fingerprint of the scene.
        """
        import numpy
        import xarray

        columns = self._columns()
        names = [name for name in (self._rows[0].parameters if self._rows else {})]
        values = {name: list(dict.fromkeys(columns[name])) for name in names}
        sets = numpy.prod([len(v) for v in values.values()], dtype=int) if names else 0
        paths = {item.split("=")[0].split("/")[-1]: item.split("=")[0] for item in self._vary}
        varied = [name for name in names if name in paths]
        grid = self._grid and self._options.get("design") in (None, "grid") and varied == names
        data: Dict[str, Any] = {}
        if grid and sets >= len(self._rows):
            shape = [len(values[name]) for name in names]
            where = tuple(
                numpy.array([values[name].index(v) for v in columns[name]], dtype=int)
                for name in names
            )
            for name, found in columns.items():
                if name not in names:
                    data[name] = (names, numpy.full(shape, numpy.nan))
                    data[name][1][where] = found
            coordinates: Dict[str, Any] = {name: values[name] for name in names}
        else:
            data = {name: ("set", v) for name, v in columns.items() if name not in names}
            coordinates = {name: ("set", columns[name]) for name in names}
        attributes = {self._option: self._vary, "fingerprint": self.report.get("fingerprint", "")}
        dataset = xarray.Dataset(data, coords=coordinates, attrs=attributes)
        for name, unit in self._units().items():
            for column in (name, name + "_u"):
                dataset[column].attrs["units"] = unit
        for name, path in paths.items():
            if name in dataset.coords:
                dataset.coords[name].attrs["path"] = path
        return dataset

    # Notebooks.

    def _page(self) -> str:
        return os.path.splitext(str(self._options["output"]))[0] + ".html"

    def _repr_html_(self) -> Optional[str]:
        """The page of plots, in a frame of its own."""
        page = self._page()
        if not os.path.exists(page):
            return None
        with open(page, encoding="utf-8") as file:
            words = html.escape(file.read())
        style = "width: 100%; height: 480px; border: 0"
        return '<iframe srcdoc="%s" style="%s" sandbox="allow-scripts"></iframe>' % (words, style)


def merged_tables(tables: Any, output: Path, options: Mapping[str, Any]) -> Mapping[str, Any]:
    """The table of parts of a sweep."""
    names = [ffi.new("char[]", path_bytes(table, "tables")) for table in listed(tables)]
    files = ffi.new("char *[]", names)
    words = options_json({**options, "output": os.fsdecode(path_bytes(output, "output"))})
    found: Mapping[str, Any] = json_of("mcv_tables_merge", files, len(names), words)
    return found

# SPDX-License-Identifier: Apache-2.0
"""Rigs: scenes that are read, changed by path and rendered."""

from __future__ import annotations

import base64
import html
import json
import os
import threading
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional, Tuple

from mcvisi._verbs import RigVerbs
from mcvisi.bar import Bar
from mcvisi.errors import BadInput, PathError, UsageError
from mcvisi.findings import Findings
from mcvisi.group import Group
from mcvisi.library import (
    Handle,
    call,
    ffi,
    json_of,
    library,
    new_pointer,
    path_bytes,
    take_text,
    text_of,
    utf8,
)
from mcvisi.options import Path, joined, options_json, value_json
from mcvisi.session import ProgressOption, Session, session_of

if TYPE_CHECKING:
    from mcvisi.detection import Detection
    from mcvisi.image import Image
    from mcvisi.optimization import Optimization
    from mcvisi.sweep import Sweep
    from mcvisi.transport import Transport
    from mcvisi.uncertainty import Uncertainty

# A line names so many elements of a kind.
_SHOWN_NAMES = 6


def _path_bytes(path: Any) -> bytes:
    if not isinstance(path, str):
        raise UsageError(
            'a path of a scene is a text such as "sensors/camera/fNumber", not %s'
            % type(path).__name__
        )
    if "\0" in path:
        raise PathError("a path of a scene has no NUL character")
    return utf8(path, "a path of a scene")


class Rig(RigVerbs, Handle):
    """
    A scene: camera, lights and parts, as the JSON document of a glTF file.

    rig["sensors/camera/fNumber"] = 8 changes it by the paths of the program's --set; the same is
    rig.sensors.camera.fNumber = 8. Texts may have units: "80mm". Changes are in memory until
    save(). What is wrong inside of the scene is told by the first call that uses it.
    """

    _what = "rig"

    #: The picture so far of the last render of this rig that was interrupted.
    interrupted: Optional["Image"] = None
    #: What mcvisi.new and mcvisi.import_lens have chosen.
    report: Mapping[str, Any]

    def __init__(self, document: Mapping[str, Any], folder: Optional[Path] = None) -> None:
        """A rig from its JSON document. File names in it are relative to `folder`."""
        words = value_json("document", document)
        self._own(
            new_pointer(
                "mcv_rig",
                "mcv_rig_parse",
                words,
                len(words),
                ffi.NULL if folder is None else path_bytes(folder, "folder"),
            )
        )

    def _own(self, pointer: Any, report: Optional[Mapping[str, Any]] = None) -> None:
        Handle.__init__(self, pointer, "mcv_rig_free")
        self._lock = threading.Lock()  # of one short call that reads or changes the document
        self.report = report or {}

    @classmethod
    def _of(cls, pointer: Any, report: Optional[Mapping[str, Any]] = None) -> "Rig":
        rig = cls.__new__(cls)
        rig._own(pointer, report)
        return rig

    def close(self) -> None:
        """Frees the scene. Calls that still run keep it."""
        self._pointer = None

    def __enter__(self) -> "Rig":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # The document.

    def __getitem__(self, path: str) -> Any:
        """The JSON at a path, as it is written; "" is all of it. A copy: to change it, assign."""
        name = _path_bytes(path)
        with self._lock:
            try:
                return json_of("mcv_rig_get", self._get(), name)
            except BadInput as error:
                raise PathError(str(error)) from None

    def __setitem__(self, path: str, value: Any) -> None:
        name = _path_bytes(path)
        with self._lock:
            try:
                call("mcv_rig_set", self._get(), name, value_json(path, value))
            except BadInput as error:
                raise PathError(str(error)) from None

    def __contains__(self, path: object) -> bool:
        try:
            self[path]  # type: ignore[index]
        except PathError:
            return False
        return True

    def paths(self) -> List[str]:
        """The paths that the document has, in its order."""
        with self._lock:
            found: List[str] = json_of("mcv_rig_paths", self._get())
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self.paths())

    def _children(self, path: str) -> List[str]:
        begin = path + "/" if path else ""
        names = [p[len(begin) :].split("/")[0] for p in self.paths() if p.startswith(begin)]
        return list(dict.fromkeys(names))

    def _member(self, path: str) -> Any:
        value = self[path]
        return Group(self, path) if isinstance(value, dict) else value

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError("%r object has no attribute %r" % (type(self).__name__, name))
        if self._pointer is None:
            raise AttributeError("this rig is closed")
        if name not in self._children(""):
            raise AttributeError(
                "a rig has no %r; this one has %s" % (name, ", ".join(self._children("")))
            )
        return Group(self, name)

    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: Any) -> None:
            """Refuses what would change nothing in the scene."""
            if not (name.startswith("_") or name == "report" or hasattr(type(self), name)):
                raise AttributeError(
                    "rig.%s cannot be set: a value of the scene is set by its path, as in "
                    'rig["sensors/camera/fNumber"] = 8' % name
                )
            object.__setattr__(self, name, value)

    def __dir__(self) -> List[str]:
        names = [] if self._pointer is None else self._children("")
        return sorted({*object.__dir__(self), *names})

    def _ipython_key_completions_(self) -> List[str]:
        return self.paths()

    # Files and copies.

    @property
    def path(self) -> Optional[str]:
        """The file that the rig was read from or last saved to."""
        with self._lock:
            return os.fsdecode(ffi.string(library().mcv_rig_path(self._get()))) or None

    @property
    def folder(self) -> str:
        """The folder that file names in the document are relative to."""
        with self._lock:
            return os.fsdecode(ffi.string(library().mcv_rig_folder(self._get()))) or "."

    def save(self, path: Optional[Path] = None) -> None:
        """
        Writes the document, whole or not at all; by default where it came from. It must stay in
        its folder, because file names in it are relative.
        """
        target = self.path if path is None else path
        if target is None:
            raise UsageError("save: this rig has no file yet: name one")
        with self._lock:
            call("mcv_rig_save", self._get(), path_bytes(target, "path"))

    def _snapshot(self) -> Any:
        """A copy for a long call: the rig may be changed or closed meanwhile."""
        with self._lock:
            pointer = new_pointer("mcv_rig", "mcv_rig_copy", self._get())
        return ffi.gc(pointer, library().mcv_rig_free)

    def copy(self) -> "Rig":
        """A rig that can be changed on its own."""
        with self._lock:
            return Rig._of(new_pointer("mcv_rig", "mcv_rig_copy", self._get()), self.report)

    __copy__ = copy

    def __deepcopy__(self, _memo: Dict[int, Any]) -> "Rig":
        return self.copy()

    def __reduce__(self) -> Tuple[Any, ...]:
        return (Rig, (self._whole_document(), os.path.abspath(self.folder)))

    def _whole_document(self) -> Dict[str, Any]:
        """With the binary chunk of a .glb file as a data: URI."""
        document: Dict[str, Any] = self[""]
        buffers = document.get("buffers") or [{"uri": ""}]
        if "uri" not in buffers[0] and self.path is not None:
            chunk = _binary_chunk(self.path)
            words = base64.b64encode(chunk[: buffers[0]["byteLength"]]).decode()
            buffers[0]["uri"] = "data:application/octet-stream;base64," + words
        return document

    def __repr__(self) -> str:
        if self._pointer is None:
            return "<mcvisi.Rig closed>"
        groups = ["%s: %s" % (name, _few(self._children(name))) for name in self._children("")]
        return "<mcvisi.Rig %s; %s>" % (self.path or "not saved", "; ".join(groups))

    def _repr_html_(self) -> str:
        rows = []
        for path in self.paths():
            value = self[path]
            if not isinstance(value, dict):
                words = (html.escape(path), html.escape(json.dumps(value)))
                rows.append("<tr><td><code>%s</code></td><td>%s</td></tr>" % words)
        title = html.escape(self.path or "not saved")
        return "<table><caption>%s</caption>%s</table>" % (title, "".join(rows))

    # Work.

    def _check(self, session: Optional[Session], options: Mapping[str, Any]) -> Findings:
        rig = self._snapshot()
        with session_of(session)._used() as used:
            report = json_of("mcv_session_check", used, rig, options_json(options))
        return Findings(report)

    def _render(
        self,
        progress: ProgressOption,
        session: Optional[Session],
        options: Mapping[str, Any],
        stop: Optional[threading.Event] = None,
    ) -> "Image":
        rig = self._snapshot()
        self.interrupted = None
        try:
            with Bar(progress) as told:
                image: "Image" = session_of(session)._render(rig, options, told, stop)
                return image
        except BaseException as error:
            self.interrupted = getattr(error, "image", None)
            raise

    def _warm(
        self, session: Optional[Session], options: Mapping[str, Any]
    ) -> List[Mapping[str, Any]]:
        rig, used = self._snapshot(), session_of(session)
        with used._used() as pointer:
            words = options_json(options)
            programs: List[Mapping[str, Any]] = json_of("mcv_session_warm", pointer, rig, words)[
                "programs"
            ]
        return programs

    def _explain(
        self, pixel: Any, session: Optional[Session], options: Mapping[str, Any]
    ) -> Mapping[str, Any]:
        rig = self._snapshot()
        words = options_json({**options, "pixel": joined(pixel, "pixel")})
        with session_of(session)._used() as used:
            found: Mapping[str, Any] = json_of("mcv_session_explain", used, rig, words)
        return found

    def _transport(
        self, progress: ProgressOption, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Transport":
        rig = self._snapshot()
        with Bar(progress) as told:
            return session_of(session)._render_matrix(rig, options, told)

    def _deflectometry(
        self, progress: ProgressOption, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Image":
        rig = self._snapshot()
        with Bar(progress) as told:
            return session_of(session)._deflectometry(rig, options, told)

    def _scan(
        self, progress: ProgressOption, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Image":
        rig = self._snapshot()
        with Bar(progress) as told:
            return session_of(session)._scan(rig, options, told)

    async def _render_async(
        self, progress: ProgressOption, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Image":
        import asyncio

        stop = threading.Event()
        try:
            return await asyncio.to_thread(self._render, progress, session, options, stop)
        except asyncio.CancelledError:
            stop.set()
            raise

    def _camera_model(self, options: Mapping[str, Any]) -> Mapping[str, Any]:
        found: Mapping[str, Any] = json.loads(self._export_camera(options))
        return found

    def _export_camera(self, options: Mapping[str, Any]) -> str:
        return text_of("mcv_rig_camera_model", self._snapshot(), options_json(options))

    def _import_camera(self, path: Path, options: Mapping[str, Any]) -> Mapping[str, Any]:
        name, words = path_bytes(path, "path"), options_json(options)
        with self._lock:
            found: Mapping[str, Any] = json_of("mcv_rig_add_camera", self._get(), name, words)
        return found

    def _add_defect(self, kind: str, options: Mapping[str, Any]) -> Mapping[str, Any]:
        name, words = utf8(kind, "kind"), options_json(options)
        with self._lock:
            found: Mapping[str, Any] = json_of("mcv_rig_add_defect", self._get(), name, words)
        return found

    def _trace(
        self, rays: Any, session: Optional[Session], options: Mapping[str, Any]
    ) -> Dict[str, Any]:
        import numpy

        try:
            values = numpy.ascontiguousarray(rays, dtype=float)
        except (TypeError, ValueError):
            raise UsageError("rays: must be an array of numbers") from None
        if values.ndim != 2 or values.shape[1] != 6:
            raise UsageError("rays: must have six numbers each, origin and direction")
        rig, used = self._snapshot(), session_of(session)
        words = used._options(options)
        table = ffi.new("char **")
        with used._used() as pointer:
            call(
                "mcv_session_trace",
                pointer,
                rig,
                ffi.from_buffer("double[]", values),
                len(values),
                words,
                table,
                ffi.NULL,
            )
        return _columns(take_text(table))

    def _sweep(
        self, vary: Any, progress: Any, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Sweep":
        from mcvisi.sweep import Sweep

        return Sweep(self, session_of(session), vary, progress, options)

    def _optimize(
        self, vary: Any, progress: Any, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Optimization":
        from mcvisi.optimization import Optimization

        return Optimization(self, session_of(session), vary, progress, options)

    def _uncertainty(
        self, tolerance: Any, progress: Any, session: Optional[Session], options: Mapping[str, Any]
    ) -> "Uncertainty":
        from mcvisi.uncertainty import Uncertainty

        return Uncertainty(self, session_of(session), tolerance, progress, options)

    def _pod(
        self,
        vary: Any,
        study: Any,
        progress: Any,
        session: Optional[Session],
        options: Mapping[str, Any],
    ) -> "Detection":
        from mcvisi.detection import Detection

        return Detection(self, session_of(session), vary, study, progress, options)


def _few(names: List[str]) -> str:
    """The first names, and how many more there are."""
    more = len(names) - _SHOWN_NAMES
    return ", ".join(names[:_SHOWN_NAMES]) + (" and %d more" % more if more > 0 else "")


def _binary_chunk(path: str) -> bytes:
    """The second chunk of a .glb file. Behind 12 bytes, each has its length and type first."""
    with open(path, "rb") as file:
        content = file.read()
    at = 20 + int.from_bytes(content[12:16], "little")
    return content[at + 8 : at + 8 + int.from_bytes(content[at : at + 4], "little")]


def _columns(table: str) -> Dict[str, Any]:
    """A table of comma-separated values, by column: numbers where all are."""
    import csv

    import numpy

    rows = list(csv.reader(table.splitlines()))
    columns: Dict[str, Any] = {}
    for name, *texts in zip(*rows):
        try:
            columns[name] = numpy.array([float(text or "nan") for text in texts])
        except ValueError:
            columns[name] = numpy.array(texts)
    return columns

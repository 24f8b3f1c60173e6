# SPDX-License-Identifier: Apache-2.0
"""Sessions: an OpenCL device with its programs, and what renders have in common."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import threading
import time
import warnings
from typing import (
    TYPE_CHECKING,
    Any,
    Callable,
    Iterator,
    List,
    Literal,
    Mapping,
    Optional,
    Type,
    Union,
)

from mcvisi import opencl
from mcvisi.errors import DeviceError, Error, UsageError
from mcvisi.library import Handle, call, check, ffi, json_of, library, new_pointer, take_text
from mcvisi.options import options_json
from mcvisi.work import Job

if TYPE_CHECKING:
    from mcvisi.image import Image
    from mcvisi.transport import Transport

# Callbacks come at most so often [s].
_INTERVAL = 0.1
_INTERRUPTED = 130


def devices() -> List[Mapping[str, Any]]:
    """
    The OpenCL devices: number, name, type, compute units, memory. The option `device` takes a
    number or a name. The device "reference", the independent renderer on the CPU, is always there
    and not listed.
    """
    found: List[Mapping[str, Any]] = json_of("mcv_devices")["devices"]
    return found


class Progress:
    """
    What a running render tells.

    fraction: how much is done, 0 to 1; NaN while the kernels are compiled. seconds: since the call.
    error: the relative error so far; infinite while it is not known.
    """

    def __init__(self, job: Job, told: Any) -> None:
        self.fraction = float(told.fraction)
        self.seconds = float(told.seconds)
        self.error = float(told.error)
        self._job: Optional[Job] = job
        self._told = told

    def __repr__(self) -> str:
        return "Progress(fraction=%.3g, seconds=%.3g, error=%.3g)" % (
            self.fraction,
            self.seconds,
            self.error,
        )

    def image(self) -> Optional["Image"]:
        """The picture so far; None before each pixel has its first samples. Only while the
        callback runs."""
        if self._job is None:
            raise UsageError("Progress.image: the callback is over")
        pointer = self._job.ask(
            lambda: new_pointer("mcv_picture", "mcv_progress_picture", self._told)
        )
        return _image(pointer, {})

    def save(self) -> None:
        """Writes the checkpoint of the render (the option `checkpoint`) before it goes on. Only
        while the callback runs."""
        if self._job is None:
            raise UsageError("Progress.save: the callback is over")
        self._job.ask(lambda: call("mcv_progress_save", self._told))


# None: a bar in a terminal and in a notebook. False: nothing. A function: it is called about ten
# times a second in the thread of the render's caller; where it returns False the render stops.
ProgressOption = Union[None, Literal[False], Callable[[Progress], Optional[bool]]]


def _image(pointer: Any, stats: Mapping[str, Any]) -> Optional["Image"]:
    from mcvisi.image import Image

    return Image._of(pointer, stats) if pointer != ffi.NULL else None


class _Render:
    """One render of an image: what its thread does, and what reaches the caller."""

    def __init__(self, arguments: "tuple[Any, Any, bytes]", told: bool) -> None:
        self.arguments = arguments
        self.told = told
        self.image: Optional["Image"] = None
        self._next = 0.0

    def work(self, job: Job) -> Any:
        def progress(_user: Any, told: Any) -> bool:
            now = time.monotonic()
            if self.told and now >= self._next and not job.stopped:
                job.tell_and_wait(Progress(job, told))
                self._next = time.monotonic() + _INTERVAL
            return not job.stopped

        return self._call(ffi.callback("mcv_progress_call", progress, error=False))

    def _call(self, callback: Any) -> Any:
        error = ffi.new("mcv_error *")
        picture, stats = ffi.new("mcv_picture **"), ffi.new("char **")
        code = library().mcv_session_render(
            *self.arguments, callback, ffi.NULL, picture, stats, error
        )
        self.image = _image(picture[0], _report(stats))
        if self.image is None or code != _INTERRUPTED:
            check(code, error)
        assert self.image is not None
        return self.image


class _TransportRender(_Render):
    """One render of a light transport matrix."""

    def _call(self, callback: Any) -> Any:
        from mcvisi.transport import Transport

        made, report = ffi.new("mcv_transport **"), ffi.new("char **")
        call("mcv_session_transport", *self.arguments, callback, ffi.NULL, made, report)
        return Transport._of(made[0], _report(report))


class _Deflectometry(_Render):
    """The slopes and heights of a part."""

    function = "mcv_session_deflectometry"

    def _call(self, callback: Any) -> Any:
        made, report = ffi.new("mcv_picture **"), ffi.new("char **")
        call(self.function, *self.arguments, callback, ffi.NULL, made, report)
        return _image(made[0], _report(report))


class _Scan(_Deflectometry):
    """The heights that a laser head finds."""

    function = "mcv_session_scan"


def _report(text: Any) -> Mapping[str, Any]:
    words = take_text(text)
    report: Mapping[str, Any] = json.loads(words) if words else {}
    return report


class Session(Handle):
    """
    A device with its programs, and what consecutive renders have in common: assets, acceleration
    structure, textures. One session serves one call at a time; calls of other threads wait. The
    functions of a rig use one common session unless they are given another.

    device: a number or a name of mcvisi.devices(), or "reference"; precision, threads, schedule: as
    for Rig.render. They count where a call does not say otherwise.
    """

    _what = "session"

    def __init__(
        self,
        *,
        device: Union[None, int, str] = None,
        precision: Optional[Literal["single", "mixed", "double"]] = None,
        threads: Optional[int] = None,
        schedule: Optional[Literal["auto", "tile", "stream"]] = None,
    ) -> None:
        options = {
            "device": None if device is None else str(device),
            "precision": precision,
            "threads": threads,
            "schedule": schedule,
        }
        pointer = new_pointer("mcv_session", "mcv_session_open", options_json(options))
        super().__init__(pointer, "mcv_session_close")
        self._chosen = device is not None or precision == "double"
        self._lock = threading.Lock()
        self._telling: Optional[int] = None  # the thread in which a callback runs

    def close(self) -> None:
        """Releases the device, once the calls that run have ended."""
        self._pointer = None

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return "<mcvisi.Session%s>" % ("" if self._pointer is not None else " closed")

    @contextlib.contextmanager
    def _used(self) -> Iterator[Any]:
        """The session for one short call."""
        self._enter()
        try:
            yield self._get()
        finally:
            self._lock.release()

    def _enter(self) -> None:
        global _process
        self._get()
        if _process not in (None, os.getpid()):
            raise UsageError(
                "OpenCL was used by the process that has forked this one, and does not survive "
                'fork: use multiprocessing\'s start method "spawn"'
            )
        _process = os.getpid()
        if self._telling == threading.get_ident():
            raise UsageError(
                "this session renders: a progress callback may not use it; give it a session of "
                "its own"
            )
        self._lock.acquire()

    def _begin(self, work: Callable[[Job], Any]) -> Job:
        """Work in a thread, to which the session belongs until it ends."""

        def owned(job: Job) -> Any:
            try:
                return work(job)
            finally:
                self._lock.release()

        job = Job(owned)
        self._enter()
        try:
            job.start()
        except BaseException:
            self._lock.release()
            raise
        return job

    def _options(self, options: Mapping[str, Any]) -> bytes:
        """With the reference renderer where there is no OpenCL device."""
        if self._chosen or options.get("device") is not None:
            return options_json(options)
        if options.get("precision") != "double" and not _has_device():
            options = {**options, "device": "reference"}
        return options_json(options)

    def _render(
        self,
        rig: Any,
        options: Mapping[str, Any],
        progress: Optional[Callable[[Progress], Optional[bool]]],
        stop: Optional[threading.Event] = None,
        kind: Type[_Render] = _Render,
    ) -> Any:
        told = progress is not None or stop is not None
        render = kind((self._get(), rig, self._options(options)), told)
        job = self._begin(render.work)

        def tell(item: Progress) -> None:
            go_on: Optional[bool] = None
            self._telling = threading.get_ident()
            try:
                go_on = progress(item) if progress is not None else None
            finally:
                self._telling = item._job = None
            if go_on is False or (stop is not None and stop.is_set()):
                job.stop()
            else:
                job.seen()

        try:
            return job.wait(tell)
        except Error:
            raise
        except BaseException as interruption:
            # Ctrl-C, or an exception of the callback: the picture so far goes with it.
            job.stop()
            with contextlib.suppress(Error):
                job.wait()
            interruption.image = render.image  # type: ignore[attr-defined]
            raise

    def _render_matrix(
        self,
        rig: Any,
        options: Mapping[str, Any],
        progress: Optional[Callable[[Progress], Optional[bool]]],
    ) -> "Transport":
        made: "Transport" = self._render(rig, options, progress, None, _TransportRender)
        return made

    def _deflectometry(
        self,
        rig: Any,
        options: Mapping[str, Any],
        progress: Optional[Callable[[Progress], Optional[bool]]],
    ) -> "Image":
        made: "Image" = self._render(rig, options, progress, None, _Deflectometry)
        return made

    def _scan(
        self,
        rig: Any,
        options: Mapping[str, Any],
        progress: Optional[Callable[[Progress], Optional[bool]]],
    ) -> "Image":
        made: "Image" = self._render(rig, options, progress, None, _Scan)
        return made


# Which process has used OpenCL.
_process: Optional[int] = None
_found = _warned = False


def _frames_of_package() -> int:
    """How many calls deep the caller is in this package: a warning points to the user's line."""
    frame, folder, count = sys._getframe(1), os.path.dirname(__file__), 0
    while frame is not None and frame.f_code.co_filename.startswith(folder):
        count += 1
        frame = frame.f_back  # type: ignore[assignment]
    return count


def _has_device() -> bool:
    """Warns once where there is none."""
    global _found, _warned
    try:
        there = [] if _found else devices()
        _found = _found or any(opencl.knows_processor(device) for device in there)
        if _found:
            return True
        if there:
            opencl.hint = (
                "; PoCL is there, but does not know this processor: install a newer one, such as "
                "pocl-opencl-icd"
            )
    except DeviceError:
        pass
    if not _warned:
        _warned = True
        warnings.warn(
            "there is no OpenCL device: the reference renderer is used, which is slow"
            + (opencl.hint or "; install pocl-opencl-icd, or `pip install mcvisi[cpu]`"),
            RuntimeWarning,
            stacklevel=_frames_of_package() + 1,
        )
    return False


_default: Optional[Session] = None
_default_lock = threading.Lock()


def session_of(given: Optional[Session]) -> Session:
    """The session that a call was given, or the one of all calls that are given none."""
    global _default
    if isinstance(given, Session):
        return given
    if given is not None:
        raise UsageError("session: must be a mcvisi.Session, not %s" % type(given).__name__)
    with _default_lock:
        if _default is None or _default._pointer is None:
            _default = Session()
        return _default

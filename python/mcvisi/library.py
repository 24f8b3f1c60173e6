# SPDX-License-Identifier: Apache-2.0
"""The shared library: loaded at its first use, its calls with exceptions in place of codes."""

from __future__ import annotations

import glob
import json
import keyword
import os
import re
import threading
from typing import Any

from mcvisi._abi import ffi as ffi
from mcvisi.errors import Error, UsageError, error_of
from mcvisi.opencl import find_opencl
from mcvisi.options import PLURALS

_lock = threading.Lock()
_library: Any = None


SYSTEM_LIBRARY = "libmcvisi.so.0"


def _open() -> Any:
    """The library beside the package, as wheels have it, or the system's, as Debian has it."""
    folder = os.path.dirname(__file__)
    beside = sorted(glob.glob(os.path.join(glob.escape(folder), "libmcvisi.so*")))
    try:
        return ffi.dlopen(beside[0] if beside else SYSTEM_LIBRARY)
    except OSError as error:
        raise Error(
            "the library cannot be loaded (%s): install the wheel or the package libmcvisi0, or "
            "build by `./run python`" % error
        ) from None


def library() -> Any:
    """The library's functions. OpenCL is looked for before the library is loaded."""
    global _library
    if _library is None:
        with _lock:
            if _library is None:
                find_opencl()
                _library = _open()
    return _library


# An option of the program; command lines are left as they are.
_OPTION = re.compile(r"`mcvisi[^`]*`|(?<![\w-])--([a-z](?:[a-z-]*[a-z])?)(?![\w-])")


def _option(found: "re.Match[str]") -> str:
    name = found[1]
    if name is None:
        return found[0]
    words = name.replace("-", "_")
    return words + "_" if keyword.iskeyword(words) else PLURALS.get(name, words)


def in_python(sentence: str) -> str:
    """The program's sentence, in which options are called as in Python."""
    return _OPTION.sub(_option, sentence)


def check(code: int, error: Any) -> None:
    """Raises what the library said."""
    if code:
        raise error_of(code, in_python(ffi.string(error.text).decode("utf-8", "replace")))


def call(name: str, *arguments: Any) -> None:
    """Calls a function whose last argument is the error. Other threads run meanwhile."""
    error = ffi.new("mcv_error *")
    check(getattr(library(), name)(*arguments, error), error)


def take_text(out: Any) -> str:
    """The text of a `char **` that the library has set; frees it. NULL is ""."""
    if out[0] == ffi.NULL:
        return ""
    try:
        return str(ffi.string(out[0]).decode("utf-8", "replace"))
    finally:
        library().mcv_text_free(out[0])


def text_of(name: str, *arguments: Any) -> str:
    """Calls a function whose last outputs are a text and the error."""
    out = ffi.new("char **")
    call(name, *arguments, out)
    return take_text(out)


def json_of(name: str, *arguments: Any) -> Any:
    """text_of of a JSON report."""
    return json.loads(text_of(name, *arguments))


def utf8(text: Any, what: str) -> bytes:
    """A text for the library."""
    if not isinstance(text, str):
        raise UsageError("%s: must be a text, not %s" % (what, type(text).__name__))
    try:
        words: bytes = text.encode()
        return words
    except UnicodeEncodeError:
        raise UsageError("%s: %r is no text that UTF-8 has" % (what, text)) from None


def path_bytes(path: Any, what: str) -> bytes:
    """A file name for the library."""
    try:
        name = os.fsencode(path)
    except TypeError:
        words = "%s: must be a file name, not %s" % (what, type(path).__name__)
        raise UsageError(words) from None
    except UnicodeEncodeError:
        raise UsageError("%s: %r is no file name" % (what, path)) from None
    if b"\0" in name:
        raise UsageError("%s: a file name has no NUL character" % what)
    return name


class Handle:
    """Owns a pointer of the library, which is freed when nobody uses it any more: closing drops
    it, and a call that still runs in another thread keeps it for as long."""

    _what = "object"
    _pointer: Any = None

    def __init__(self, pointer: Any, free: str, size: int = 0) -> None:
        self._pointer = ffi.gc(pointer, getattr(library(), free), size)

    def _get(self) -> Any:
        pointer = self._pointer
        if pointer is None:
            raise UsageError("this %s is closed" % self._what)
        return pointer

    def __reduce__(self) -> Any:
        raise UsageError("a %s cannot be copied or pickled" % self._what)


def new_pointer(kind: str, name: str, *arguments: Any) -> Any:
    """Calls a function whose last outputs are a pointer and the error; returns the pointer."""
    out = ffi.new(kind + " **")
    call(name, *arguments, out)
    return out[0]

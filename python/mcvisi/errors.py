# SPDX-License-Identifier: Apache-2.0
"""What the library's failures are in Python: one sentence each, and its code."""

from __future__ import annotations

from typing import Dict, Iterable, Type


class Error(Exception):
    """The work failed. `code` is the exit code that the program has for it."""

    code = 1


class UsageError(Error, TypeError):
    """Wrong usage: an option that does not exist, a handle that is closed or busy."""

    code = 2


class BadInput(Error, ValueError):
    """A file, a path of a scene or a value that is not what it must be."""

    code = 3


class DeviceError(Error, RuntimeError):
    """Trouble with the OpenCL device."""

    code = 4


class PathError(BadInput, KeyError):
    """A path that the scene does not have, or a name that a result does not have: what
    `rig[path]` and `result[name]` raise."""

    # KeyError would put the sentence into quotes.
    __str__ = Exception.__str__


def unknown_name(what: str, name: object, known: Iterable[str]) -> PathError:
    """The exception for a name that a result does not have."""
    return PathError("%s has no %r; it has %s" % (what, name, ", ".join(known) or "nothing"))


_CLASSES: Dict[int, Type[Error]] = {c.code: c for c in (Error, UsageError, BadInput, DeviceError)}


def error_of(code: int, sentence: str) -> Error:
    """The exception for a code of the library other than 0."""
    error = _CLASSES.get(code, Error)(sentence)
    error.code = code
    return error

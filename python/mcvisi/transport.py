# SPDX-License-Identifier: Apache-2.0
"""Light transport matrices: what each element of the emitters brings to each pixel."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Mapping

from mcvisi.errors import UsageError
from mcvisi.image import Image, temporary_folder
from mcvisi.library import (
    Handle,
    call,
    ffi,
    json_of,
    new_pointer,
    path_bytes,
    take_text,
)
from mcvisi.options import Path, options_json, value_json

if TYPE_CHECKING:
    import numpy


class _Array:
    """Memory of a matrix for numpy, which keeps this and thereby the matrix."""

    def __init__(self, owner: "Transport", pointer: Any, shape: Any, kind: str) -> None:
        self._owner = owner
        self.__array_interface__ = {
            "version": 3,
            "shape": shape,
            "typestr": kind,
            "data": (int(ffi.cast("uintptr_t", pointer)), True),
        }


def _numbers(values: Any, what: str) -> "numpy.ndarray[Any, Any]":
    import numpy

    try:
        return numpy.asarray(values, dtype=numpy.float32)
    except (TypeError, ValueError) as error:
        raise UsageError("%s: must be an array of numbers: %s" % (what, error)) from None


class Transport(Handle):
    """
    A light transport matrix. Its product with a pattern is the image of that pattern.

    matrix: a scipy.sparse.csr_array without a copy; row pixel * channels + channel, column element.
    replicates: of each entry its value by each replicate, (entries, replicates).
    pattern: what the scene shows, (elements, channels). header: pixel grid, elements, attributes.
    """

    _what = "light transport matrix"

    #: What was rendered: size, elements, entries, seconds.
    report: Mapping[str, Any]

    def __init__(self, path: Path) -> None:
        """Reads a matrix (.npz)."""
        self._own(new_pointer("mcv_transport", "mcv_transport_read", path_bytes(path, "path")), {})

    def _own(self, pointer: Any, report: Mapping[str, Any]) -> None:
        Handle.__init__(self, pointer, "mcv_transport_free")
        self.report = report
        self.header: Mapping[str, Any] = json_of("mcv_transport_header", pointer)
        self._entries = ffi.new("mcv_matrix_entries *", {"size": ffi.sizeof("mcv_matrix_entries")})
        call("mcv_transport_entries", pointer, self._entries)

    @classmethod
    def _of(cls, pointer: Any, report: Mapping[str, Any]) -> "Transport":
        made = cls.__new__(cls)
        made._own(pointer, report)
        return made

    def _array(self, pointer: Any, shape: Any, kind: str) -> "numpy.ndarray[Any, Any]":
        import numpy

        return numpy.asarray(_Array(self, pointer, shape, kind))

    @property
    def matrix(self) -> Any:
        """A scipy.sparse.csr_array, which needs SciPy."""
        import scipy.sparse  # type: ignore[import-untyped]

        e = self._entries
        return scipy.sparse.csr_array(
            (
                self._array(e.values, (e.entry_count,), "<f8"),
                self._array(e.columns, (e.entry_count,), "<i4"),
                self._array(e.row_begins, (e.row_count + 1,), "<i8"),
            ),
            shape=(e.row_count, e.column_count),
        )

    @property
    def replicates(self) -> "numpy.ndarray[Any, Any]":
        """Of each entry its value by each replicate, (entries, replicates)."""
        e = self._entries
        return self._array(e.replicates, (e.entry_count, e.replicate_count), "<f4")

    @property
    def pattern(self) -> "numpy.ndarray[Any, Any]":
        """What the scene shows, (elements, channels)."""
        shape = (self._entries.element_count, self.header["channels"])
        return self._array(self._entries.pattern, shape, "<f4")

    def elements(self, emitter: str) -> slice:
        """The rows of a pattern that belong to an emitter, pixel by pixel."""
        for group in self.header["elements"]:
            if isinstance(emitter, str) and group["emitter"] == emitter:
                first = group["first"]
                return slice(first, first + group["width"] * group["height"])
        raise UsageError(
            "emitter: there is no %r, but %s"
            % (emitter, ", ".join(repr(group["emitter"]) for group in self.header["elements"]))
        )

    def relight(self, pattern: Any = None) -> Image:
        """
        The image of a pattern, with its standard error from the replicates.

        pattern: an array (elements, channels), or (elements,) for all channels; or a dictionary of
        arrays (rows, columns[, channels]) or numbers by the emitter's name, where the others are as
        in the scene; None: that of the scene.
        """
        picture = ffi.new("mcv_picture **")
        report = ffi.new("char **")
        values = self._values(pattern)
        call(
            "mcv_transport_relight",
            self._get(),
            ffi.from_buffer("float[]", values),
            values.size,
            options_json({}),
            picture,
            report,
        )
        return Image._of(picture[0], json.loads(take_text(report) or "{}"))

    def sequence(self, pattern: Mapping[str, Any], emitter: str | None = None) -> "list[Image]":
        """
        The images of a sequence of patterns, one after the other.

        pattern: as in scenes, {"type": "phaseShift", "steps": 4, "periods": 16}. emitter: which one
        shows it; None: the only one with pixels.
        """
        if not isinstance(pattern, Mapping):
            raise UsageError("pattern: must be a dictionary, not %s" % type(pattern).__name__)
        shown = value_json("pattern", dict(pattern)).decode()
        words = shown if emitter is None else "%s=%s" % (emitter, shown)
        options = options_json({"sequence": words})
        count = ffi.new("size_t *")
        none = ffi.NULL
        call("mcv_transport_sequence", self._get(), options, none, 0, count, none)
        pictures = ffi.new("mcv_picture *[]", count[0])
        call("mcv_transport_sequence", self._get(), options, pictures, count[0], count, none)
        return [Image._of(picture, {}) for picture in pictures]

    def fit(self, wanted: str, region: str | None = None, background: str | None = None) -> Image:
        """
        The image with the weights of the emitters, 0 or more, that fit best; report["weights"] of
        the image holds them, with their standard errors.

        wanted: "uniform", an even region (by default the whole image), or "contrast", the region
        against the background. Regions are "X,Y,W,H", polygons, or names of mask images.
        """
        picture = ffi.new("mcv_picture **")
        report = ffi.new("char **")
        given = {"fit": wanted, "region": region, "background": background, "json": True}
        options = options_json({key: value for key, value in given.items() if value is not None})
        call("mcv_transport_relight", self._get(), ffi.NULL, 0, options, picture, report)
        return Image._of(picture[0], json.loads(take_text(report) or "{}"))

    def deflection(self, reference: "Transport | None" = None) -> "tuple[Image, Image]":
        """
        How a part deflects light: the deflection (rows, columns, x and y) with its error, and
        the histograms of directions, as an image of a light field camera.

        It needs the directions of a light field emitter or camera. reference: the same set-up
        without the part.
        """
        picture, histogram = ffi.new("mcv_picture **"), ffi.new("mcv_picture **")
        report = ffi.new("char **")
        call(
            "mcv_transport_deflection",
            self._get(),
            ffi.NULL if reference is None else _matrix(reference, "reference"),
            options_json({"json": True}),
            picture,
            histogram,
            report,
        )
        return (
            Image._of(picture[0], json.loads(take_text(report) or "{}")),
            Image._of(histogram[0], {}),
        )

    def inverse_pattern(
        self,
        method: str = "replay",
        field: str = "bright",
        emitter: str | None = None,
        bits: int = 8,
        damping: float | None = None,
    ) -> Image:
        """
        The pattern, from 0 to 1, under which the part of this matrix looks even, with its error.

        method: "replay" or "least-squares". field: "bright", or "dark", the complement. relight
        takes the pattern, also of the matrix of another part: relight({emitter: pattern}).
        """
        picture, report = ffi.new("mcv_picture **"), ffi.new("char **")
        given: dict[str, Any] = {"method": method, "field": field, "emitter": emitter, "bits": bits}
        given.update({"damping": damping, "json": True})
        options = options_json({key: value for key, value in given.items() if value is not None})
        call("mcv_transport_inverse", self._get(), options, picture, report)
        return Image._of(picture[0], json.loads(take_text(report) or "{}"))

    def _values(self, pattern: Any) -> "numpy.ndarray[Any, Any]":
        import numpy

        whole = numpy.array(self.pattern)
        if isinstance(pattern, Mapping):
            for emitter, shown in pattern.items():
                part = whole[self.elements(emitter)]
                array = _numbers(shown, "pattern: %s" % emitter)
                try:
                    part[:] = array if array.ndim == 0 else array.reshape(len(part), -1)
                except ValueError as error:
                    raise UsageError("pattern: %s: %s" % (emitter, error)) from None
        elif pattern is not None:
            array = _numbers(pattern, "pattern")
            if array.shape not in (whole.shape, whole.shape[:1]):
                raise UsageError("pattern: must have the shape %s" % (whole.shape,))
            whole[:] = array.reshape(len(whole), -1)
        return numpy.ascontiguousarray(whole)

    def save(self, path: Path) -> None:
        """Writes .npz, or .mtx (MatrixMarket) with the values alone."""
        call("mcv_transport_write", self._get(), path_bytes(path, "path"))

    def __reduce__(self) -> "tuple[Any, ...]":
        with temporary_folder() as folder:
            path = os.path.join(folder, "matrix.npz")
            self.save(path)
            with open(path, "rb") as file:
                return (_unpickled, (file.read(), dict(self.report)))

    def __repr__(self) -> str:
        e = self._entries
        return "<mcvisi.Transport %d x %d, %d entries>" % (
            e.row_count,
            e.column_count,
            e.entry_count,
        )


def _matrix(transport: Any, what: str) -> Any:
    if not isinstance(transport, Transport):
        raise UsageError(
            "%s: must be a mcvisi.Transport, not %s" % (what, type(transport).__name__)
        )
    return transport._get()


def _unpickled(content: bytes, report: Mapping[str, Any]) -> Transport:
    with temporary_folder() as folder:
        path = os.path.join(folder, "matrix.npz")
        with open(path, "wb") as file:
            file.write(content)
        transport = Transport(path)
    transport.report = report
    return transport

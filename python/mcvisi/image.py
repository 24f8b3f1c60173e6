# SPDX-License-Identifier: Apache-2.0
"""Images: float32 values with their standard error, and what can be done with them."""

from __future__ import annotations

import glob
import json
import os
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple

from mcvisi._verbs import ImageVerbs
from mcvisi.errors import UsageError
from mcvisi.library import (
    Handle,
    call,
    ffi,
    json_of,
    library,
    new_pointer,
    path_bytes,
    take_text,
)
from mcvisi.measurement import Measurement
from mcvisi.options import Path, listed, options_json

if TYPE_CHECKING:
    import tempfile

    import numpy

    from mcvisi.rig import Rig

# A notebook shows an image at most so wide [pixels].
_SHOWN_WIDTH = 1200


def temporary_folder() -> "tempfile.TemporaryDirectory[str]":
    import tempfile  # here, as importing it takes longer than importing this package

    return tempfile.TemporaryDirectory(prefix="mcvisi-")


class _Part:
    """The values of one part for numpy, which keeps this and thereby the picture."""

    def __init__(self, image: "Image", part: Any) -> None:
        self._image = image
        self.name = str(ffi.string(part.name).decode())
        width, height, channels = part.width, part.height, part.channels
        shape: Tuple[int, ...] = (height, width)
        strides: Tuple[int, ...] = (4 * width, 4)
        if channels > 1:
            shape, strides = (*shape, channels), (*strides, 4 * width * height)
        self.__array_interface__ = {
            "version": 3,
            "shape": shape,
            "strides": strides,
            "typestr": "<f4",
            "data": (int(ffi.cast("uintptr_t", part.planes)), True),
        }


def _planes(values: Any, what: str) -> Any:
    """float32 [channel][row][column] of an array (row, column[, channel])."""
    import numpy

    try:
        if numpy.iscomplexobj(values):
            raise TypeError("these are complex")
        array = numpy.asarray(values, dtype=numpy.float32)
    except (TypeError, ValueError) as error:
        raise UsageError("%s: must be an array of numbers: %s" % (what, error)) from None
    if array.ndim == 2:
        array = array[:, :, None]
    if array.ndim != 3 or array.shape[2] not in (1, 3) or 0 in array.shape:
        raise UsageError(
            "%s: must be an array (rows, columns) or (rows, columns, 3), not %s"
            % (what, numpy.shape(values))
        )
    return numpy.ascontiguousarray(array.transpose(2, 0, 1))


class Image(ImageVerbs, Handle):
    """
    An image: float32 values of shape (rows, columns) or (rows, columns, 3).

    numpy.asarray(image) is a view of the values, without a copy and read-only; it keeps the image.
    error, samples: the same for the standard error of each value, and the samples of each pixel.
    """

    _what = "image"

    #: The summary of the render, or what camera() has done: a report in SI units.
    report: Mapping[str, Any]

    def __init__(
        self,
        values: Any,
        error: Any = None,
        attributes: Optional[Mapping[str, Any]] = None,
    ) -> None:
        """An image of values in memory, which are copied, and of their standard uncertainty."""
        planes = _planes(values, "values")
        deviation = None if error is None else _planes(error, "error")
        if deviation is not None and deviation.shape != planes.shape:
            raise UsageError("error: must have the shape of the values")
        channels, height, width = planes.shape
        self._own(
            new_pointer(
                "mcv_picture",
                "mcv_picture_make",
                width,
                height,
                channels,
                ffi.from_buffer("float[]", planes),
                ffi.NULL if deviation is None else ffi.from_buffer("float[]", deviation),
                ffi.NULL if attributes is None else _attributes_json(attributes),
            ),
            {},
        )

    def _own(self, pointer: Any, report: Mapping[str, Any]) -> None:
        self._parts: Dict[str, _Part] = {}
        part = ffi.new("mcv_part *")
        size = 0
        Handle.__init__(self, pointer, "mcv_picture_free")
        for index in range(library().mcv_picture_part_count(pointer)):
            part.size = ffi.sizeof("mcv_part")
            call("mcv_picture_part", pointer, index, part)
            found = _Part(self, part)
            self._parts.setdefault(found.name, found)
            size += 4 * part.width * part.height * part.channels
        self._bytes = size
        self.report = report

    @classmethod
    def _of(cls, pointer: Any, report: Mapping[str, Any]) -> "Image":
        image = cls.__new__(cls)
        image._own(pointer, report)
        return image

    # Values.

    @property
    def __array_interface__(self) -> Dict[str, Any]:
        return next(iter(self._parts.values())).__array_interface__

    @property
    def shape(self) -> Tuple[int, ...]:
        """(rows, columns) or (rows, columns, channels)."""
        shape: Tuple[int, ...] = self.__array_interface__["shape"]
        return shape

    @property
    def dtype(self) -> "numpy.dtype[Any]":
        """float32."""
        kind: "numpy.dtype[Any]" = self.array.dtype
        return kind

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        """Values by numpy's rules: image[row, column], image[10:20], image[mask]."""
        return self.array[key]

    @property
    def parts(self) -> List[str]:
        """The names of all parts: "image", "error", "replicate 0" …"""
        return list(self._parts)

    def part(self, name: str) -> "numpy.ndarray[Any, Any]":
        """The values of a part, a read-only view."""
        import numpy

        if not isinstance(name, str) or name not in self._parts:
            raise UsageError("this image has no part %r; it has %s" % (name, ", ".join(self.parts)))
        return numpy.asarray(self._parts[name])

    def _part_or_none(self, name: str) -> "Optional[numpy.ndarray[Any, Any]]":
        return self.part(name) if name in self._parts else None

    @property
    def array(self) -> "numpy.ndarray[Any, Any]":
        """The values, a read-only view."""
        return self.part(self.parts[0])

    @property
    def error(self) -> "Optional[numpy.ndarray[Any, Any]]":
        """The standard error of each value, a read-only view; None where it is not known."""
        return self._part_or_none("error")

    @property
    def samples(self) -> "Optional[numpy.ndarray[Any, Any]]":
        """The samples of each pixel, a read-only view; None where all pixels have the same."""
        return self._part_or_none("samples")

    @property
    def attributes(self) -> Mapping[str, Any]:
        """What the header says."""
        found: Mapping[str, Any] = json_of("mcv_picture_attributes", self._get())
        return found

    @property
    def unit(self) -> str:
        """The unit of the values: "W/m^2", "DN"."""
        return str(self.attributes.get("mcvisi:unit", ""))

    @property
    def camera_model(self) -> Optional[Mapping[str, Any]]:
        """Where the points of the scene lie in the image: K, R and t, or the affine matrix A."""
        words = self.attributes.get("mcvisi:cameraModel")
        model: Optional[Mapping[str, Any]] = json.loads(words) if words else None
        return model

    def __repr__(self) -> str:
        size = " x ".join(map(str, (self.shape[1], self.shape[0], *self.shape[2:])))
        return "<mcvisi.Image %s%s; %s>" % (
            size,
            " [%s]" % self.unit if self.unit else "",
            ", ".join(self.parts),
        )

    # Files.

    def save(self, path: Path, *, preview: bool = False) -> None:
        """
        Writes the image, whole or not at all. .exr: values, errors and header; .png: a preview in
        8 bits. Grey values of a camera as .png, .tif or .npy: the values as they are; `preview`
        writes FILE-preview.png too.
        """
        options = options_json({"preview": preview})
        call("mcv_picture_write", self._get(), path_bytes(path, "path"), options)

    def __reduce__(self) -> Tuple[Any, ...]:
        with temporary_folder() as folder:
            path = os.path.join(folder, "image.exr")
            self.save(path)
            with open(path, "rb") as file:
                return (_unpickled, (file.read(), dict(self.report)))

    def _repr_png_(self) -> bytes:
        """The preview of a notebook."""
        shown = self._smaller(_SHOWN_WIDTH)
        with temporary_folder() as folder:
            path = os.path.join(folder, "image.png")
            shown.save(path, preview=True)
            preview = glob.glob(os.path.join(glob.escape(folder), "*-preview.png"))
            with open(preview[0] if preview else path, "rb") as file:
                return file.read()

    def _smaller(self, width: int) -> "Image":
        """At most so wide: the means of squares of pixels."""
        step = -(-self.shape[1] // width)
        if step == 1 or self.shape[0] < step:
            return self
        rows, columns = self.shape[0] // step * step, self.shape[1] // step * step
        cells = self.array[:rows, :columns].reshape(
            rows // step, step, columns // step, step, *self.shape[2:]
        )
        return Image(cells.mean(axis=(1, 3)), attributes=_plain_attributes(self.attributes))

    # Work.

    def _camera(self, options: Mapping[str, Any]) -> "Image":
        report = ffi.new("char **")
        grey = ffi.new("mcv_picture **")
        call("mcv_picture_camera", self._get(), options_json(options), grey, report)
        return Image._of(grey[0], json.loads(take_text(report)))

    def _measure(
        self, minus: Optional["Image"], rig: Optional["Rig"], options: Mapping[str, Any]
    ) -> Measurement:
        report = json_of(
            "mcv_picture_measure",
            self._get(),
            ffi.NULL if minus is None else _picture(minus, "minus"),
            ffi.NULL if rig is None else _rig(rig),
            options_json(options),
        )
        return Measurement(report, self.unit)

    def _views(self, options: Mapping[str, Any]) -> "Image":
        words = options_json(options)
        return Image._of(_made("mcv_picture_views", self._get(), words), {})

    def _detect(self, without: "Image", options: Mapping[str, Any]) -> Mapping[str, Any]:
        found: Mapping[str, Any] = json_of(
            "mcv_picture_detect",
            self._get(),
            _picture(without, "without"),
            options_json(options),
            ffi.NULL,
        )
        return found

    def _emd_gradient(self, options: Mapping[str, Any]) -> "Image":
        words = options_json(options)
        return Image._of(_made("mcv_picture_emd_gradient", self._get(), words), {})


def _made(name: str, *arguments: Any) -> Any:
    """Calls a function that makes a picture and a report; the report is not wanted."""
    made = ffi.new("mcv_picture **")
    call(name, *arguments, made, ffi.NULL)
    return made[0]


def _attributes_json(attributes: Any) -> bytes:
    try:
        return json.dumps(dict(attributes), allow_nan=False).encode()
    except (TypeError, ValueError):
        raise UsageError("attributes: must be a dictionary of texts and numbers") from None


def _plain_attributes(attributes: Mapping[str, Any]) -> Mapping[str, Any]:
    """Those that still hold for other pixels."""
    return {key: attributes[key] for key in ("mcvisi:unit",) if key in attributes}


def _picture(image: Any, what: str) -> Any:
    if not isinstance(image, Image):
        raise UsageError("%s: must be a mcvisi.Image, not %s" % (what, type(image).__name__))
    return image._get()


def _rig(rig: Any) -> Any:
    from mcvisi.rig import Rig

    if not isinstance(rig, Rig):
        raise UsageError("rig: must be a mcvisi.Rig, not %s" % type(rig).__name__)
    return rig._snapshot()


def merged(films: Sequence[Path], options: Mapping[str, Any]) -> Image:
    """The image of parts of a render."""
    names = [ffi.new("char[]", path_bytes(film, "films")) for film in listed(films)]
    picture, report = ffi.new("mcv_picture **"), ffi.new("char **")
    files = ffi.new("char *[]", names)
    call("mcv_films_merge", files, len(names), options_json(options), picture, report)
    return Image._of(picture[0], json.loads(take_text(report) or "{}"))


def read(path: Path) -> Image:
    """Reads an image: .exr, or grey values from .png, .tif or .npy."""
    return Image._of(new_pointer("mcv_picture", "mcv_picture_read", path_bytes(path, "path")), {})


def _unpickled(content: bytes, report: Mapping[str, Any]) -> Image:
    with temporary_folder() as folder:
        path = os.path.join(folder, "image.exr")
        with open(path, "wb") as file:
            file.write(content)
        image = read(path)
    image.report = report
    return image


class Comparison:
    """
    Whether two renders differ by more than their noise.

    different: True or False, and reason why. difference: (a - b) in units of its standard error.
    report: the tests and their p-values.
    """

    def __init__(self, difference: Image, report: Mapping[str, Any]) -> None:
        self.difference, self.report = difference, report
        self.different, self.reason = bool(report["different"]), str(report["reason"])

    def __repr__(self) -> str:
        return "<mcvisi.Comparison: %s; %s>" % (
            "different" if self.different else "not different",
            self.reason,
        )


def compare(a: Image, b: Image) -> Comparison:
    """
    Tells whether two renders of the same picture differ by more than their noise. Render both with
    parts="replicates" for rank tests.
    """
    difference, report = ffi.new("mcv_picture **"), ffi.new("char **")
    pictures = (_picture(a, "a"), _picture(b, "b"))
    call("mcv_picture_compare", *pictures, ffi.NULL, ffi.NULL, difference, report)
    return Comparison(Image._of(difference[0], {}), json.loads(take_text(report)))

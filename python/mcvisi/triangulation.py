# SPDX-License-Identifier: Apache-2.0
"""Laser triangulation: from images of a laser line to heights."""

from __future__ import annotations

import json
import os
from typing import Any, Mapping

from mcvisi.image import Image, read, temporary_folder
from mcvisi.library import ffi, path_bytes, text_of
from mcvisi.options import listed, options_json


def _file(image: Any, number: int, folder: str) -> Any:
    """The name of an image's file; an image in memory is written, with its header."""
    if isinstance(image, Image):
        path = os.path.join(folder, "image-%d.exr" % number)
        image.save(path)
        image = path
    return ffi.new("char[]", path_bytes(image, "images"))


def heights(images: Any, laser: str, options: Mapping[str, Any]) -> Image:
    """The range image of the profiles, which the library writes as it writes `output`."""
    several, output = listed(images), options["output"]
    with temporary_folder() as folder:
        path = os.path.join(folder, "range.exr")
        files = [path] if output is None else [*listed(output), path]
        words = options_json({**options, "laser": laser, "output": files})
        names = [_file(image, number, folder) for number, image in enumerate(several)]
        array = ffi.new("char *[]", names)
        report = json.loads(text_of("mcv_images_triangulate", array, len(names), words))
        found = read(path)
    found.report = report
    return found

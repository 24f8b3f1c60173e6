# SPDX-License-Identifier: Apache-2.0
"""Where rigs come from: files, parts and lens files."""

from __future__ import annotations

import json
from typing import Any, Mapping

from mcvisi.library import call, ffi, new_pointer, path_bytes, take_text, utf8
from mcvisi.options import Path, options_json
from mcvisi.rig import Rig


def load(path: Path) -> Rig:
    """Reads a scene (.gltf, .glb)."""
    return Rig._of(new_pointer("mcv_rig", "mcv_rig_open", path_bytes(path, "path")))


def _made(name: str, *arguments: Any) -> Rig:
    rig, report = ffi.new("mcv_rig **"), ffi.new("char **")
    call(name, *arguments, rig, report)
    return Rig._of(rig[0], json.loads(take_text(report) or "{}"))


def new_rig(kind: str, part: Path, options: Mapping[str, Any]) -> Rig:
    """A rig around a part."""
    words = options_json(options)
    return _made("mcv_rig_new", utf8(str(kind), "kind"), path_bytes(part, "part"), words)


def lens_rig(path: Path, options: Mapping[str, Any]) -> Rig:
    """A lens file as a scene."""
    return _made("mcv_rig_import", path_bytes(path, "path"), options_json(options))

# SPDX-License-Identifier: Apache-2.0
"""Parts of a rig by attributes: rig.sensors.camera."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Iterator, List

from mcvisi.errors import PathError

if TYPE_CHECKING:
    from mcvisi.rig import Rig


class Group:
    """A part of a rig, whose members are attributes: rig.sensors.camera.fNumber = 8."""

    __slots__ = ("_rig", "_path")

    def __init__(self, rig: "Rig", path: str) -> None:
        object.__setattr__(self, "_rig", rig)
        object.__setattr__(self, "_path", path)

    def __getitem__(self, key: str) -> Any:
        return self._rig._member("%s/%s" % (self._path, key))

    def __setitem__(self, key: str, value: Any) -> None:
        self._rig["%s/%s" % (self._path, key)] = value

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return self[name]
        except PathError as error:
            raise AttributeError(str(error)) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value

    def __iter__(self) -> Iterator[str]:
        return iter(self._rig._children(self._path))

    def __dir__(self) -> List[str]:
        return [name for name in self if name.isidentifier()]

    def _ipython_key_completions_(self) -> List[str]:
        return list(self)

    def __repr__(self) -> str:
        return "%s: %s" % (self._path, json.dumps(self._rig[self._path], indent=2))

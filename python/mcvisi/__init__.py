# SPDX-License-Identifier: Apache-2.0
"""
MC ViSi: simulation of machine-vision systems.

    import mcvisi as mv
    rig = mv.new("telecentric", "part.stl", unit="mm")
    rig["sensors/camera/fNumber"] = 8
    image = rig.render(error=0.01, time=30)
    image.save("part.exr")

A rig is a scene: camera, lights and parts. An image holds values and the standard error of each.
Lengths are in metres, angles in radians, times in seconds, unless a text gives a unit.
Failures are exceptions with one sentence: mcvisi.Error and its classes.
"""

from mcvisi._verbs import (
    import_lens,
    merge,
    merge_tables,
    new,
    pod_table,
    pod_values,
    triangulate,
)
from mcvisi._version import __version__
from mcvisi import examples
from mcvisi.depths import Depth, depth
from mcvisi.detection import Detection
from mcvisi.errors import BadInput, DeviceError, Error, PathError, UsageError
from mcvisi.findings import Finding, Findings
from mcvisi.group import Group
from mcvisi.image import Comparison, Image, compare, read
from mcvisi.measurement import Figures, Measurement, Value
from mcvisi.options import linear, log
from mcvisi.rig import Rig
from mcvisi.rigs import load
from mcvisi.session import Progress, Session, devices
from mcvisi.optimization import Optimization
from mcvisi.sweep import Row, Sweep
from mcvisi.transport import Transport
from mcvisi.uncertainty import Uncertainty

__all__ = [
    "BadInput",
    "Comparison",
    "Depth",
    "Detection",
    "DeviceError",
    "Error",
    "Figures",
    "Finding",
    "Findings",
    "Group",
    "Image",
    "Measurement",
    "Optimization",
    "PathError",
    "Progress",
    "Rig",
    "Row",
    "Session",
    "Sweep",
    "Transport",
    "Uncertainty",
    "UsageError",
    "Value",
    "__version__",
    "compare",
    "depth",
    "devices",
    "examples",
    "import_lens",
    "linear",
    "load",
    "log",
    "merge",
    "merge_tables",
    "new",
    "pod_table",
    "pod_values",
    "read",
    "triangulate",
]

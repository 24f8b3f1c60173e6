# SPDX-License-Identifier: Apache-2.0
"""The console script: the program of this package, with the OpenCL that the package finds."""

import os
import sys

from mcvisi.opencl import find_opencl


def main() -> None:
    """Becomes the program."""
    find_opencl()
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "mcvisi")
    try:
        os.execv(program, ["mcvisi", *sys.argv[1:]])
    except OSError as error:
        sys.exit("mcvisi: %s: %s" % (program, error.strerror))

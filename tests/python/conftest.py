# SPDX-License-Identifier: Apache-2.0
"""Rigs for the tests of the Python package."""

import mcvisi as mv
import pytest
from mcvisi import examples


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Where a bracket lies."""
    path = tmp_path_factory.mktemp("parts")
    examples.bracket(path / "bracket.stl")
    return path


@pytest.fixture
def rig(folder):
    """A telecentric camera of 96 x 64 pixels before a backlight."""
    return mv.new("telecentric", folder / "bracket.stl", unit="mm", resolution=(96, 64))


@pytest.fixture
def image(rig):
    return rig.render(spp=16, progress=False)

# SPDX-License-Identifier: Apache-2.0
"""A host process with a decimal comma."""

import ctypes
import locale
import subprocess

import mcvisi as mv
import numpy as np
import pytest

DEFINITION = (
    "".join(
        '%s\ncopy "POSIX"\nEND %s\n' % (name, name)
        for name in ("LC_CTYPE", "LC_COLLATE", "LC_MONETARY", "LC_MESSAGES", "LC_TIME")
    )
    + 'LC_NUMERIC\ndecimal_point ","\nthousands_sep "."\ngrouping 3;3\nEND LC_NUMERIC\n'
)


@pytest.fixture
def comma(tmp_path, monkeypatch):
    """A locale whose numbers have a decimal comma, made on the spot: few machines have one."""
    (tmp_path / "comma.definition").write_text(DEFINITION)
    command = ["localedef", "-c", "-i", "comma.definition", "./comma"]
    try:
        # It complains about the categories that are left out, and writes the locale.
        subprocess.run(command, cwd=tmp_path, capture_output=True)
    except FileNotFoundError:
        pytest.skip("there is no localedef to make a locale with")
    monkeypatch.setenv("LOCPATH", str(tmp_path))
    before = locale.setlocale(locale.LC_NUMERIC)
    locale.setlocale(locale.LC_NUMERIC, "comma")
    text = ctypes.create_string_buffer(16)
    ctypes.CDLL(None).snprintf(text, 16, b"%.1f", ctypes.c_double(1.5))
    assert text.value == b"1,5"
    yield
    locale.setlocale(locale.LC_NUMERIC, before)


def test_a_decimal_comma(rig, tmp_path, comma):
    places = {"left": (8, 34, 18, 16)}
    rig["sensors/camera/fNumber"] = 5.6
    rig["nodes/light/distance"] = "41.4mm"
    image = rig.render(spp=16, time="100.5s", progress=False)
    found = image.measure(edges=places)["left"].position
    image.save(tmp_path / "a.exr")
    rows = rig.sweep({"nodes/light/distance": ["41.4mm"]}, metrics=["left.position"], edges=places)
    assert rows.rows[0].parameters["distance"] == 0.0414
    locale.setlocale(locale.LC_NUMERIC, "C")
    again = rig.render(spp=16, time="100.5s", progress=False)
    assert np.array_equal(np.asarray(image), np.asarray(again))
    assert again.measure(edges=places)["left"].position == found
    read = mv.read(tmp_path / "a.exr")
    assert read.camera_model == image.camera_model == again.camera_model

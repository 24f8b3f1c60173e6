# SPDX-License-Identifier: Apache-2.0
"""Deflectometry: the heights of a mirror whose tilt is known."""

import math

import mcvisi as mv
import numpy as np
import pytest

TILT = 0.01
COLUMNS, ROWS = 16, 12
SHOWN = {"plane": "table", "spp": 1024, "progress": False}


def mirror(tilt=0.0, **pattern):
    """
    A mirror of 80 mm, turned about y; camera and screen are 250 mm away, 25° to both sides. A pixel
    of the camera sees w = 1.2 mm of the screen, whose pixels are p = 0.25 mm.
    """

    def posed(name, azimuth, **what):
        at = {"target": [0, 0, 0], "distance": "250mm", "azimuth": azimuth}
        return {"name": name, "extensions": {"MCVISI_pose": at, **what}}

    shown = {"type": "phaseShift", "steps": 4, "periods": 40, "resolution": [1280, 1024], **pattern}
    screen = {"type": "screen", "pixelPitch": "0.25mm", "radiance": 100, "pattern": shown}
    camera = {"type": "pinhole", "imageDistance": "25mm", "pixelSize": "60um"}
    disc = {"name": "mirror", "type": "disc", "radius": "40mm", "material": "chrome"}
    part = {"name": "mirror", "extensions": {"MCVISI_surfaces": {"surface": 0}}}
    part["rotation"] = [0, math.sin(tilt / 2), 0, math.cos(tilt / 2)]
    chrome = {"name": "chrome", "extensions": {"MCVISI_materials": {"type": "mirror"}}}
    return mv.Rig(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0, 1, 2, 3]}],
            "extensions": {
                "MCVISI_sensors": {
                    "sensors": [{"name": "camera", **camera, "resolution": [COLUMNS, ROWS]}]
                },
                "MCVISI_emitters": {"emitters": [{"name": "screen", **screen}]},
                "MCVISI_surfaces": {"surfaces": [disc]},
            },
            "materials": [chrome],
            "nodes": [
                {"name": "table"},
                part,
                posed("camera", "-25deg", MCVISI_sensors={"sensor": 0}),
                posed("screen", "25deg", MCVISI_emitters={"emitter": 0}),
            ],
        }
    )


def test_a_tilted_mirror():
    image = mirror(TILT).deflectometry(**SHOWN)
    assert np.asarray(image).shape == image.error.shape == (ROWS, COLUMNS) and image.unit == "m"
    slope, u, place = (image.part(name) for name in ("slope", "slope error", "place"))
    assert slope.shape == u.shape == place.shape == (ROWS, COLUMNS, 2)
    # Steps of the screen's pixels bend places by p²/(π² w) at most, slopes by that over 0.5 m. Of
    # 384 normal errors none passes 5 deviations.
    bound = 0.25e-3**2 / (math.pi**2 * 1.2e-3) / 0.5 + 5 * u.max()
    assert np.abs(slope[..., 0] + math.tan(TILT)).max() < bound < 1e-4
    assert np.abs(slope[..., 1]).max() < bound
    # The plane through the origin: the slopes' error over the way to it.
    way = np.hypot(place[..., 0], place[..., 1])
    assert np.all(
        np.abs(np.asarray(image) + math.tan(TILT) * place[..., 0]) < 2 * bound * way.max()
    )
    assert image.report["pixels"] == ROWS * COLUMNS


def test_files_and_progress(tmp_path):
    told = []
    image = mirror().deflectometry(
        plane="table",
        spp=64,
        output=tmp_path / "h.exr",
        png=tmp_path / "h.png",
        progress=told.append,
    )
    assert (tmp_path / "h.png").exists() and told
    assert all(t.fraction != t.fraction or 0 <= t.fraction <= 1 for t in told)  # NaN: compiling
    read = mv.read(tmp_path / "h.exr")
    assert np.array_equal(np.asarray(read), np.asarray(image)) and read.parts == image.parts


def test_the_render_may_be_stopped():
    with pytest.raises(mv.Error) as caught:
        mirror().deflectometry(plane="table", spp=2**24, progress=lambda told: False)
    assert caught.value.code == 130
    assert mirror().deflectometry(plane="table", spp=16, progress=False).shape == (ROWS, COLUMNS)


def test_refused(rig):
    for options, sentence in (
        ({"plane": "tabel"}, "tabel"),
        ({"plane": "table", "screen": "lamp"}, "has no screen of this name"),
        ({"plane": "table", "output": "a.png"}, "must end in .exr"),
        ({"plane": "table", "noise": float("nan")}, "noise: must be a finite number"),
    ):
        with pytest.raises(mv.UsageError, match=sentence):
            mirror().deflectometry(progress=False, **options)
    with pytest.raises(TypeError, match="plane"):
        mirror().deflectometry()
    with pytest.raises(mv.BadInput, match="at least 2 are needed"):
        mirror(periods=1).deflectometry(**SHOWN)
    with pytest.raises(mv.BadInput, match="no emitter of the type screen"):
        rig.deflectometry(plane="camera", progress=False)

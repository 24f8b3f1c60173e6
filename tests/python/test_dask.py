# SPDX-License-Identifier: Apache-2.0
"""The Dask example of docs/long-renders.md runs as printed, on two processes."""

import pathlib
import re

import mcvisi as mv
import numpy as np
import pytest

SOURCES = pathlib.Path(__file__).resolve().parents[2]
PAGE = (SOURCES / "docs/long-renders.md").read_text(encoding="utf-8")
EXAMPLE = re.search(r"^### Dask$.*?^```python\n(.*?)^```$", PAGE, re.S | re.M)


def test_the_example_gives_the_image_of_one_render(tmp_path):
    distributed = pytest.importorskip("distributed", reason="Dask is not installed")
    assert EXAMPLE, "docs/long-renders.md has no Dask example"
    scene = (SOURCES / "scenes/beam.gltf").read_text(encoding="utf-8")
    (tmp_path / "part.gltf").write_text(scene.replace("[320, 240]", "[24, 16]"), encoding="utf-8")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        code = EXAMPLE[1].replace("scheduler:8786", cluster.scheduler_address)
        names = {"__name__": "__main__"}
        exec(compile(code.replace("/shared", str(tmp_path)), "docs/long-renders.md", "exec"), names)
        names["client"].close()
    whole = mv.load(tmp_path / "part.gltf").render(samples=(0, 512), progress=False)
    assert np.array_equal(np.asarray(names["image"]), np.asarray(whole))
    assert float(np.mean(np.asarray(whole))) > 0

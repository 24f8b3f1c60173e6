# SPDX-License-Identifier: Apache-2.0
"""The code of docs/python.md runs as printed, and makes the page's pictures.

MCVISI_PICTURES=1 puts the pictures that it makes into docs/python.
"""

import ast
import inspect
import os
import pathlib
import re
import shutil
import textwrap

import mcvisi as mv
import numpy as np
import pytest
from mcvisi import examples

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "python.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.S | re.M)
PICTURES = re.findall(r"!\[[^]]*\]\((python/[^)]+\.png)\)", PAGE)
# Levels of 255 by which a picture may differ in the mean: other devices, other fonts.
LEVELS = 3


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """What the page's code has left: its names, its folder and what it printed."""
    pytest.importorskip("xarray")
    pytest.importorskip("matplotlib").use("Agg")
    folder = tmp_path_factory.mktemp("page")
    examples.bracket(folder / "bracket.stl")
    before, names = os.getcwd(), {}
    os.chdir(folder)
    try:
        for block in BLOCKS:
            exec(compile(block, "docs/python.md", "exec"), names)
    finally:
        os.chdir(before)
    return names, folder


def test_calls_that_are_not_run():
    """They take long: their arguments are those of the functions."""
    blocks = re.findall(
        r"(?:^    .*\n|^\n)+", re.sub(r"^```.*?^```$", "", PAGE, flags=re.S | re.M), re.M
    )
    blocks = [
        block for block in map(textwrap.dedent, blocks) if re.search(r"\b(rig|mv|head)\.", block)
    ]
    found = 0
    for node in (n for block in blocks for n in ast.walk(ast.parse(block))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owners = (mv, mv.Rig, mv.Image)
            functions = [getattr(o, node.func.attr, None) for o in owners]
            functions = [f for f in functions if inspect.isfunction(f)]
            for function in functions:
                given = inspect.signature(function).bind(
                    *([None] if function.__qualname__ != function.__name__ else []),
                    *(None for _ in node.args),
                    **{word.arg: None for word in node.keywords},
                )
                found += bool(given)
    assert found >= 8


def test_the_first_script(run):
    names, folder = run
    assert len(BLOCKS[0].splitlines()) <= 17
    assert {"part.tif", "part.exr", "bracket.png"} <= {path.name for path in folder.iterdir()}
    assert names["ds"].u.dims == ("fNumber", "halfAngle") and names["ds"].u.shape == (3, 8)


def test_the_first_page_has_the_first_script():
    assert "```python\n%s```" % BLOCKS[0] in (DOCS / "index.md").read_text(encoding="utf-8")


def test_the_width_that_the_page_states(run):
    """Geometry: 57 mm, and twice the growth of the edge that check states."""
    names, _ = run
    length = names["edges"]["right"].length
    stated = re.search(r"# (57\.\d+)\((\d+)\) mm", PAGE)
    assert stated, "the page states no width"
    # The same seed, the same noise; another device rounds in another way.
    assert float(stated[1]) == pytest.approx(1e3 * length.value, abs=1e3 * length.uncertainty)
    nominal = names["width"]
    assert abs(nominal.value - examples.WIDTH * 1e-3) < 4 * nominal.uncertainty


@pytest.mark.parametrize("picture", PICTURES)
def test_pictures(run, picture):
    from matplotlib import image

    _, folder = run
    made = folder / pathlib.Path(picture).name
    if os.environ.get("MCVISI_PICTURES"):
        (DOCS / picture).parent.mkdir(exist_ok=True)
        shutil.copy(made, DOCS / picture)
    assert (DOCS / picture).stat().st_size < 200_000
    shown, here = (image.imread(path).astype(float) for path in (DOCS / picture, made))
    assert shown.shape == here.shape
    assert np.abs(shown - here).mean() * 255 < LEVELS

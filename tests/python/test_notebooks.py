# SPDX-License-Identifier: Apache-2.0
"""The notebooks run from their first cell to their last, and their own assertions hold.

Slow: together some 30 s of processor time."""

import json
import os
import pathlib
import shutil
import sys

import pytest

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "python" / "examples"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    if "opencv" in path.stem:
        pytest.importorskip("cv2")
    # As in the sources, but what the notebook writes stays here.
    examples = tmp_path / "python" / "examples"
    shutil.copytree(FOLDER, examples, ignore=shutil.ignore_patterns("*.stl", ".ipynb*"))
    os.symlink(FOLDER.parents[1] / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(examples)
    monkeypatch.setattr(sys, "path", [str(examples), *sys.path])
    notebook = json.loads(path.read_text(encoding="utf-8"))
    names, checks = {}, 0
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            assert not cell["outputs"] and cell["execution_count"] is None
            source = "".join(cell["source"])
            checks += source.count("assert ")
            exec(compile(source, path.name, "exec"), names)
    assert checks >= 1


def test_they_are_there():
    assert len(NOTEBOOKS) >= 5

# SPDX-License-Identifier: Apache-2.0
"""Sweeps: rows as they finish, tables."""

import io
import json
import math
import signal
import sys
import threading
import time

import mcvisi as mv
import numpy as np
import pytest

PLACE = {"left": (8, 34, 18, 16)}


def sweep_of(rig, **options):
    vary = {
        "sensors/camera/fNumber": [4, 8],
        "emitters/light/halfAngle": mv.log("0.2deg", "2deg", 3),
    }
    usual = {"metrics": {"u": "u(left.position)", "b": "left.bright"}, "edges": PLACE, "spp": 16}
    return rig.sweep(vary, **{**usual, **options})


def test_ranges():
    assert mv.log("0.1deg", "2deg", 8) == "0.1deg..2deg:8:log"
    assert mv.linear(0, 0.5, 3) == "0..0.5:3"
    assert mv.linear(np.float64(0.25), np.int64(2), np.int64(3)) == "0.25..2:3"
    for count in (3.0, "3", None):
        with pytest.raises(mv.UsageError, match="count: must be a whole number"):
            mv.log(1, 2, count)


def test_rows(rig):
    sweep = sweep_of(rig)
    assert "not begun" in repr(sweep)
    rows = list(sweep)
    assert len(rows) == 6 and sweep.finished
    assert {row["fNumber"] for row in rows} == {4, 8}
    assert rows[0]["halfAngle"] == pytest.approx(math.radians(0.2))
    assert all(isinstance(row["u"], mv.Value) and row["u"].value > 0 for row in rows)
    assert all(row.message is None for row in rows)
    # Light of half the f-number is four times as much; the same random numbers.
    bright = {(row["fNumber"], row["halfAngle"]): row["b"].value for row in rows}
    widest = max(row["halfAngle"] for row in rows)
    assert bright[4, widest] == pytest.approx(4 * bright[8, widest], rel=0.02)
    assert list(sweep) == rows == sweep.rows
    with pytest.raises(KeyError, match="has no 'fnumber'; it has fNumber, halfAngle, u, b"):
        rows[0]["fnumber"]


def test_parts_of_a_sweep_are_merged(rig, tmp_path):
    whole = sweep_of(rig, output=tmp_path / "whole.csv")
    tables = [tmp_path / ("%d.csv" % i) for i in (0, 1)]
    for i, table in enumerate(tables):
        list(sweep_of(rig, range=(i, 2), best={"u": "smallest"}, output=table))
    told = mv.merge_tables(tables[::-1], tmp_path / "merged.csv")
    assert told["tables"] == 2 and told["rows"] == len(whole.rows) == 6
    # But for the seconds, that of one sweep.
    merged, one = (
        [line.split(",")[:5] for line in (tmp_path / name).read_text().splitlines()]
        for name in ("merged.csv", "whole.csv")
    )
    assert merged == one
    with pytest.raises(mv.Error, match="merged.csv"):
        mv.merge_tables(tables, tmp_path / "merged.csv")
    mv.merge_tables(tables, tmp_path / "merged.csv", force=True)


@pytest.mark.parametrize("given, meant", [(False, "off"), (True, "on"), (None, None)])
def test_off_and_on_are_false_and_true(rig, tmp_path, given, meant):
    """By the experiment, which holds what was given."""
    sweep = rig.sweep(
        {"sensors/camera/fNumber": [8]},
        metrics=["mean"],
        output=tmp_path / "t.csv",
        light_paths=given,
        spp=4,
        progress=False,
    )
    assert len(sweep.rows) == 1
    assert json.loads((tmp_path / "t.json").read_text()).get("light-paths") == meant


def test_the_rig_may_change_meanwhile(rig):
    sweep = sweep_of(rig)
    rig["sensors/camera/resolution"] = [8, 8]
    assert len(sweep.rows) == 6 and not any(row.message for row in sweep)


def test_tables(rig):
    pytest.importorskip("pandas")
    sweep = sweep_of(rig)
    frame = sweep.to_pandas()
    assert list(frame.columns) == ["fNumber", "halfAngle", "u", "u_u", "b", "b_u", "message"]
    assert len(frame) == 6
    pytest.importorskip("xarray")
    data = sweep.to_xarray()
    assert data.b.dims == ("fNumber", "halfAngle") and data.b.shape == (2, 3)
    for row in sweep:
        at = data.sel(fNumber=row["fNumber"], halfAngle=row["halfAngle"])
        assert float(at.b) == row["b"].value and float(at.b_u) == row["b"].uncertainty
    assert data.fNumber.attrs["path"] == "sensors/camera/fNumber"
    assert data.u.attrs["units"] == "px" and data.b_u.attrs["units"] == "W/m^2"
    assert frame.attrs["units"] == {"u": "px", "b": "W/m^2"}
    assert len(data.attrs["fingerprint"]) == 16 and str(sweep.rows[0]["u"]).endswith("px")


def test_other_designs(rig):
    pytest.importorskip("xarray")
    data = rig.sweep(
        {"sensors/camera/fNumber": [4, 8], "emitters/light/halfAngle": ["1deg", "2deg"]},
        design="list",
        metrics=["left.bright"],
        edges=PLACE,
        spp=16,
    ).to_xarray()
    assert data.sizes == {"set": 2} and list(data.fNumber.values) == [4, 8]


def test_leaving_the_loop_keeps_the_rows(rig):
    sweep = sweep_of(rig)
    for row in sweep:
        break
    assert sweep.finished and 1 <= len(sweep.rows) < 6
    assert next(iter(sweep)) is row
    rig.render(spp=16, progress=False)


def test_a_failing_set_is_a_row(rig):
    rows = rig.sweep(
        {"sensors/camera/fNumber": [8, -8]}, metrics={"b": "left.bright"}, edges=PLACE, spp=16
    ).rows
    assert rows[0].message is None and rows[0]["b"].value > 0
    assert "fNumber" in rows[1].message and "b" not in rows[1] and rows[1]["fNumber"] == -8


def test_where_all_sets_fail(rig):
    sweep = sweep_of(rig, edges={"left": (40, 34, 18, 16)})  # no edge there
    with pytest.raises(mv.Error, match="all 6 sets failed"):
        sweep.rows
    assert len(sweep.rows) == 6 and all(row.message for row in sweep)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_bar_in_a_terminal(rig, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    for row in sweep_of(rig, error=1e-9, time=0.4, spp=2**30):
        assert terminal.getvalue().endswith("\r\x1b[K") or not terminal.getvalue()
    assert "of 6 sets" in terminal.getvalue() and terminal.getvalue().endswith("\r\x1b[K")
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert len(sweep_of(rig, progress=False, time=0.4).rows) == 6 and terminal.getvalue() == ""
    with pytest.raises(mv.UsageError, match="progress"):
        sweep_of(rig, progress=True)


def test_ctrl_c_keeps_the_rows_so_far(rig):
    sweep = sweep_of(rig, time=0.5, spp=2**30)
    rows = iter(sweep)
    next(rows)
    timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        list(rows)
    assert sweep.finished and 1 <= len(sweep.rows) < 6
    assert rig.render(spp=16, progress=False).shape == (64, 96)


def test_bad_input(rig):
    for vary in ({"sensors/none/fNumber": [1]}, {"sensors/camera/fNumber": []}):
        with pytest.raises(mv.Error):
            rig.sweep(vary, metrics=["left.bright"], edges=PLACE, spp=16).rows
    with pytest.raises(mv.UsageError):
        rig.sweep(["sensors/camera/fNumber=4"], metrics=["left.bright"], edges=PLACE)
    with pytest.raises(mv.Error):
        sweep_of(rig, metrics=["left.nothing"]).rows


def test_a_list_does_not_hide_wrong_usage(rig):
    # list() asks for the length first, and takes a TypeError of it as "not known".
    sweep = sweep_of(rig, metrics=["left.nothing"])
    for _ in range(2):
        with pytest.raises(mv.UsageError, match="nothing"):
            list(sweep)
    with pytest.raises(mv.UsageError, match="nothing"):
        sweep.to_pandas()


def test_files(rig, tmp_path):
    sweep = sweep_of(rig, output=tmp_path / "table.csv")
    assert len(sweep.rows) == 6
    assert {"table.csv", "table.json", "table.html"} <= {p.name for p in tmp_path.iterdir()}
    assert "srcdoc" in sweep._repr_html_()


def test_a_notebook_shows_it(rig):
    sweep = sweep_of(rig)
    assert sweep._repr_html_() is None
    sweep.rows
    assert "iframe" in sweep._repr_html_()


def test_another_thread_may_stop_it(rig):
    sweep = rig.sweep(
        {"sensors/camera/fNumber": [4, 8]},
        metrics=["left.bright"],
        edges=PLACE,
        time=300,
        spp=2**30,
    )
    timer = threading.Timer(1.0, sweep.stop)
    timer.start()
    before = time.monotonic()
    assert len(sweep.rows) < 2 and time.monotonic() - before < 60
    assert rig.render(spp=16, progress=False).shape == (64, 96)


def test_uncertainty(rig):
    # Light of half the stop's area is half as bright: the spread of the mean is that of d².
    study = rig.uncertainty(
        {"sensors/camera/fNumber": "normal(8,0.1)"}, metrics=["mean"], spp=16, trials=0
    )
    (name,) = study.metrics
    first = study.metrics[name]["first_order"]
    assert first["uncertainty"]["value"] == pytest.approx(
        first["centre"]["value"] * 2 * 0.1 / 8, rel=0.02
    )
    assert len(study) == 4 * 3 and "Uncertainty" in repr(study)
    with pytest.raises(mv.UsageError, match="must be normal"):
        _ = rig.uncertainty({"sensors/camera/fNumber": "gauss(1)"}, metrics=["mean"]).rows

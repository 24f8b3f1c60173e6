# SPDX-License-Identifier: Apache-2.0
"""Optimisation: the winner, its rows, fronts, constraints and what is refused."""

import math

import mcvisi as mv
import pytest

# An edge whose bright side is π L/(4 N²) with L = 1, and the rest of the picture.
PLACE = {"left": (8, 34, 18, 16)}
STOPS = [4, 8, 16]


def search_of(rig, stops=STOPS, **options):
    usual = {
        "metrics": {"b": "left.bright"},
        "objectives": {"b": "largest"},
        "edges": PLACE,
        "evaluations": 20,
        "spp": 16,
        "progress": False,
    }
    return rig.optimize({"sensors/camera/fNumber": stops}, **{**usual, **options})


def bright(stop):
    return math.pi / (4 * stop**2)


def test_the_winner(rig, tmp_path):
    # A larger stop lets more light through: the best f-number is the smallest.
    search = search_of(rig, output=tmp_path / "t.csv")
    assert "not begun" in repr(search) and "Optimization" in repr(search)
    winner = search.winner
    assert search.finished and winner["parameters"]["fNumber"] == 4 and search.front == []
    # Sums in single precision.
    assert winner["objectives"]["b"]["value"] == pytest.approx(bright(4), rel=1e-5)
    low, high = winner["interval"]
    assert low <= winner["objectives"]["b"]["value"] <= high
    # Its rows are those of a sweep.
    assert {row["fNumber"] for row in search} == set(STOPS)
    for row in search:
        assert row["b"].value == pytest.approx(bright(row["fNumber"]), rel=1e-5)
    assert {"t.csv", "t.json", "t.html"} <= {p.name for p in tmp_path.iterdir()}
    assert "srcdoc" in search._repr_html_()


def test_tables(rig):
    pytest.importorskip("xarray")
    search = search_of(rig, stops=[4, 8])
    frame, data = search.to_pandas(), search.to_xarray()
    assert list(frame.b) == [row["b"].value for row in search]
    assert data.sizes == {"set": len(search)} and data.fNumber.attrs["path"]


def test_a_front(rig):
    # What is more light in one objective is less in the other: both f-numbers are best in one.
    metrics = {"b": "left.bright", "d": "left.bright"}
    objectives = {"b": "largest", "d": "smallest"}
    search = search_of(rig, stops=[8, 16], metrics=metrics, objectives=objectives)
    assert {point["parameters"]["fNumber"] for point in search.front} == {8, 16}
    assert search.winner == {}
    # f/8 is better than f/16 in both.
    metrics["d"] = "abs(left.bright-%.9g)" % bright(8)
    search = search_of(rig, metrics=metrics, objectives=objectives)
    assert {point["parameters"]["fNumber"] for point in search.front} == {4, 8}


def test_constraints(rig):
    assert search_of(rig, where=["fNumber>5"]).winner["parameters"]["fNumber"] == 8
    # Between those of f/4 and f/8.
    limit = "b<%.9g" % (0.5 * (bright(4) + bright(8)))
    winner = search_of(rig, require=[limit]).winner
    assert winner["parameters"]["fNumber"] == 8 and winner["requirements"]


@pytest.mark.parametrize(
    "options, sentence",
    [
        ({"objectives": None}, "objective"),
        ({"objectives": {"b": "most"}}, "largest"),
        ({"objectives": {"none": "largest"}}, "none"),
        ({"evaluations": 5}, "20 or more"),
        ({"require": ["b"]}, "one comparison"),
        ({"where": ["fNumber>99"]}, "constraints allow none"),
    ],
)
def test_refused(rig, options, sentence):
    # list() asks for the length first, and takes a TypeError of it as "not known".
    search = search_of(rig, **options)
    for _ in range(2):
        with pytest.raises(mv.Error, match=sentence):
            list(search)
    with pytest.raises(mv.Error, match=sentence):
        _ = search.winner

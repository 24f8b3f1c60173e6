# SPDX-License-Identifier: Apache-2.0
"""Measured values."""

import math

import mcvisi as mv
import numpy as np
import pytest


@pytest.mark.parametrize(
    "value, uncertainty, text",
    [
        (12.34561, 0.0021, "12.3456(21)"),
        (12.3, 0.0996, "12.30(10)"),
        (0.5, 0.25, "0.50(25)"),
        (3.0, 1.25, "3.0(1.2)"),
        (1234.0, 250.0, "1230(250)"),
        (-1e-6, 1.5e-8, "-0.000001000(15)"),
        (1.5, 0.0, "1.5"),
        (1.5, math.nan, "1.5"),
    ],
)
def test_texts(value, uncertainty, text):
    assert str(mv.Value(value, uncertainty)) == text


def test_units():
    length = mv.Value(0.0123456, 2.1e-6, "m")
    assert str(length) == "12.3456(21) mm"
    assert float(length) == 0.0123456 and length.unit == "m"
    assert length.to("um").value == pytest.approx(12345.6)
    assert str(mv.Value(4.2e-6, 1e-7, "m")) == "4.20(10) µm"
    assert str(mv.Value(math.pi / 180, 1e-4, "rad")).endswith(" deg")
    assert "{:.2e} {}".format(length, length) == "1.23e-02 12.3456(21) mm"
    with pytest.raises(mv.UsageError, match="mm"):
        length.to("kg")


# An edge at column C of a perfect camera: the pixel that it crosses is so bright as it is covered.
def edge(columns, at, bright=100.0, noise=0.1):
    values = np.clip(np.arange(columns) + 1 - at, 0, 1) * bright
    return np.tile(values, (40, 1)), np.full((40, columns), noise)


def test_an_edge_of_numpys_values():
    values, error = edge(60, 30.25)
    found = mv.Image(values, error=error).measure(edges={"e": (10, 0, 40, 40)})
    position = found["e"].position
    # Noise 0.1 of 100, 40 rows: below a thousandth of a pixel.
    assert abs(position.value - 30.25) < 4 * position.uncertainty + 1e-3
    assert position.unit == "px"
    assert found["e"].bright.value == pytest.approx(100, abs=0.1)
    with pytest.raises(AttributeError, match="tilt"):
        found["e"].nothing
    with pytest.raises(KeyError, match="this measurement has no 'E'; it has e"):
        found["E"]
    assert found.get("E") is None and "E" not in found


def test_figures_of_a_rig(image):
    found = image.measure(
        edges={"left": (8, 34, 18, 16), "right": (80, 34, 16, 16)},
        regions={"bright": (0, 40, 10, 10)},
        background=(40, 40, 20, 10),
    )
    assert list(found) == ["bright", "left", "right"]
    right = found["right"]
    assert right.length.unit == "m" and right.distance.unit == "px"
    assert abs(right.length.value - 0.057) < 0.057 / 100
    assert found["bright"].mean.unit == "W/m^2"
    assert found["bright"].weber_contrast.unit == ""
    assert "left" in repr(found) and "<table>" in found._repr_html_()
    with pytest.raises(KeyError):
        found["none"]


def test_places_as_texts_and_lists(image):
    by_tuple = image.measure(lines={"l": [(8, 34, 18, 8), (8, 43, 18, 8)]})
    by_text = image.measure(lines="l=8,34,18,8+8,43,18,8")
    by_list = image.measure(lines=["l=8,34,18,8+8,43,18,8"])
    assert by_tuple.report == by_text.report == by_list.report
    on_part = image.measure(edges={"left": "@part:-25.2mm,-10mm,3mm,14mm,14mm"})
    assert on_part["left"].column.value == pytest.approx(by_tuple["l"].column.value, abs=0.1)


def test_nominal_takes_the_rig(rig, image):
    places = {"left": (8, 34, 18, 16), "right": (80, 34, 16, 16)}
    with pytest.raises(mv.Error):
        image.measure(edges=places, nominal=True)
    grown = image.measure(edges=places)["right"].length.value
    nominal = image.measure(edges=places, nominal=True, rig=rig)["right"].length.value
    assert nominal < grown


def test_a_difference(image):
    assert image.measure(minus=image)["image"].mean.value == 0
    with pytest.raises(mv.UsageError, match="minus"):
        image.measure(minus=np.asarray(image))


@pytest.mark.parametrize(
    "edges", [{"e": (1, 2, 3)}, {"e": (0, 0, 0, 0)}, {"e": "text"}, {"e": None}, 7, {"e": object()}]
)
def test_what_is_no_place(image, edges):
    with pytest.raises(mv.Error):
        image.measure(edges=edges)

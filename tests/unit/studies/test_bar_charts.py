"""A bar chart: names, lengths in proportion, and nothing that a page could not show."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import pytest

from app.studies.figures import BarChart, bar_chart_svg

AMOUNTS = {"little": 0.5, "much": 2.0, "nothing": 0.0, "<odd> & so": 1.0, "below": -0.1, "unknown": float("nan")}
_SVG = "{http://www.w3.org/2000/svg}"


def drawn(amounts):
    return ElementTree.fromstring(bar_chart_svg(BarChart('What "costs" <most>?', "times & more", amounts)))


def test_the_largest_is_on_top_and_what_is_no_number_is_left_out():
    texts = [text.text for text in drawn(AMOUNTS).iter(f"{_SVG}text")]
    names = [text for text in texts if text in AMOUNTS]
    assert names == ["much", "<odd> & so", "little", "nothing", "below"]
    assert texts[-1] == "times & more"


def test_lengths_are_in_proportion_from_zero_and_numbers_stand_behind():
    chart = drawn(AMOUNTS)
    lengths = [float(bar.get("width")) for bar in chart.iter(f"{_SVG}rect")]
    assert lengths[0] > 100
    assert lengths == pytest.approx([lengths[0], lengths[0] / 2, lengths[0] / 4, 0, 0], abs=0.1)
    assert {"2", "1", "0.5", "0", "-0.1"} <= {text.text for text in chart.iter(f"{_SVG}text")}


def test_bars_stay_within_the_picture():
    chart = drawn({f"effect {k}": float(k) for k in range(40)})
    width, height = float(chart.get("width")), float(chart.get("height"))
    for bar in chart.iter(f"{_SVG}rect"):
        assert float(bar.get("x")) + float(bar.get("width")) <= width
        assert float(bar.get("y")) + float(bar.get("height")) <= height


@pytest.mark.parametrize("amounts", [{}, {"none": float("inf")}])
def test_nothing_measured_says_so(amounts):
    texts = [text.text for text in drawn(amounts).iter(f"{_SVG}text")]
    assert "nothing measured" in texts


def test_all_below_zero_divides_by_nothing():
    assert [float(bar.get("width")) for bar in drawn({"gain": -1.0}).iter(f"{_SVG}rect")] == [0.0]

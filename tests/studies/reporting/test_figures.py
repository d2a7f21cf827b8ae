"""Figures: points are at the measured places; the SVG is complete, reproducible and readable on any page."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from tactile_maps.studies.base.figures import BarChart, Figure, Panel, draw, figure_svg, panels

SVG = "{http://www.w3.org/2000/svg}"
TEXT = f"{SVG}text"


def figure(*drawn, least=1e-9):
    return Figure("A & <B>", "seconds", "error", drawn, least=least)


def curves(axes):
    """The lines of an axes by name; intervals have none."""
    return {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}


def texts(shown):
    return ["".join(text.itertext()) for text in ElementTree.fromstring(figure_svg(shown)).iter(TEXT)]


def test_both_axes_are_logarithmic_and_points_are_joined_in_their_order():
    points = [(0.001, 1.0), (0.1, 0.0001), (0.01, 0.01)]
    (axes,) = draw(figure(Panel("one", {"ours": points}))).axes
    assert (axes.get_xscale(), axes.get_yscale(), axes.get_title()) == ("log", "log", "one")
    np.testing.assert_allclose(curves(axes)["ours"].get_xydata(), points)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("seconds", "error")
    for (low, high), values in ((axes.get_xlim(), (0.001, 0.1)), (axes.get_ylim(), (0.0001, 1.0))):
        assert low < min(values) < max(values) < high


def test_each_method_has_a_unique_style_in_all_panels():
    names = [f"method {k}" for k in range(12)]
    first, second = draw(
        figure(Panel("one", {name: [(1, 1)] for name in names}), Panel("two", {name: [(1, 1)] for name in names[::-1]}))
    ).axes
    looks = [
        {name: (line.get_color(), line.get_marker()) for name, line in curves(axes).items()} for axes in (first, second)
    ]
    assert looks[0] == looks[1]
    assert len(set(looks[0].values())) == 12


def test_zero_is_drawn_at_the_minimum_and_nan_is_omitted():
    points = [(1, 0.0), (1, np.nan), (1, np.inf), (0, 1), (1, 1e-3)]
    (axes,) = draw(figure(Panel("one", {"ours": points}), least=1e-3)).axes
    np.testing.assert_allclose(curves(axes)["ours"].get_xydata(), [[1, 1e-3], [1, 1e-3]])


@pytest.mark.parametrize("made", [{}, {"ours": []}, {"ours": [(1, 1)]}])
def test_figures_with_few_or_no_points_are_drawn(made):
    shown = texts(figure(Panel("one", made)))
    assert "one" in shown
    assert ("nothing measured" in shown) == (not any(made.values()))


@pytest.mark.long
def test_tooltip_shows_the_values_of_the_point():
    spans = {"raw": [(2.0, 16.3, math.inf), (3.0, 20.0, 30.0)]}
    curves = {"<smooth>": [(2.0, 4.52), (3.0, math.inf)], "raw": [(2.0, 19.93), (3.0, 25.0)]}
    svg = ElementTree.fromstring(figure_svg(figure(Panel("arm", curves, spans), Panel("icub", {"raw": [(5.0, 7.0)]}))))
    labels = {
        marker.findtext(f"{SVG}title"): float(marker.get("x"))
        for marker in svg.iter(f"{SVG}use")
        if marker.find(f"{SVG}title") is not None
    }
    assert list(labels) == [
        "arm, <smooth>\nseconds: 2\nerror: 4.52",
        "arm, raw\nseconds: 2\nerror: 19.9 [16.3, inf]",
        "arm, raw\nseconds: 3\nerror: 25 [20, 30]",
        "icub, raw\nseconds: 5\nerror: 7",
    ]
    smooth, raw, further, _ = labels.values()
    assert smooth == raw < further, "each at its own marker"


@pytest.mark.parametrize("x", [1.0, 3.0, 0.07, 5e-6])
def test_every_axis_has_ticks_within(x):
    (axes,) = draw(figure(Panel("one", {"ours": [(x, x)]}))).axes
    for ticks, (low, high) in ((axes.get_xticks(), axes.get_xlim()), (axes.get_yticks(), axes.get_ylim())):
        assert ((ticks > low) & (ticks < high)).any()


def test_intervals_are_vertical_in_the_colour_of_their_curve():
    made = {"ours": [(0.1, 1.0), (1.0, 0.5)]}
    spans = {"ours": [(0.1, 0.7, 2.0), (1.0, 0.5, float("inf"))]}
    (axes,) = draw(figure(Panel("one", made, spans | {"theirs": [(0.1, 0.7, 2.0)]}))).axes
    upright, endless, arrow = [line for line in axes.lines if line.get_label().startswith("_")]
    np.testing.assert_allclose(upright.get_xydata(), [[0.1, 0.7], [0.1, 2.0]])
    top = axes.get_ylim()[1]
    np.testing.assert_allclose(endless.get_xydata(), [[1.0, 0.5], [1.0, top]], err_msg="up to the top")
    np.testing.assert_allclose(arrow.get_xydata(), [[1.0, top]])
    assert upright.get_color() == arrow.get_color() == curves(axes)["ours"].get_color()


def test_intervals_of_bars_are_drawn_and_labelled():
    chart = BarChart("What?", "s", {"b": 3.0, "a": 2.0, "c": 4.0}, "", {"a": (1.5, 2.5), "b": (1.0, float("inf"))})
    (axes,) = draw(chart).axes
    first, second, third = (line.get_xdata() for line in axes.lines)
    assert [list(first), list(second), list(third)] == [[1.5, 2.5], [1.0, 3.0], [4.0, 4.0]]
    assert {"2 [1.5, 2.5]", "3 [1, inf]", "4"} <= set(texts(chart))


def test_rows_become_panels_and_curves_in_their_order():
    rows = [
        {"method": "b", "body": "tube", "ms": 1.0, "error": 2},
        {"method": "a", "body": "ball", "ms": 3.0, "error": None},
        {"method": "b", "body": "tube", "ms": 0.5, "error": 4.0},
    ]
    tube, ball = panels(rows, lambda row: row["body"], lambda row: row["method"], x="ms", y="error")
    assert (tube.title, dict(tube.curves)) == ("tube", {"b": [(1.0, 2.0), (0.5, 4.0)]})
    assert ball.title == "ball"
    assert ball.curves["a"] == [], "without an error there is nothing to draw"


AMOUNTS = {"little": 0.5, "much": 2.0, "nothing": 0.0, "<odd> & so": 1.0, "below": -0.1, "unknown": None}


def test_bars_are_sorted_and_nan_is_omitted():
    (axes,) = draw(BarChart("What costs most?", "times & more", AMOUNTS)).axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names[::-1] == ["much", "<odd> & so", "little", "nothing", "below"]
    assert [bar.get_width() for bar in axes.patches][::-1] == [2.0, 1.0, 0.5, 0.0, -0.1]
    assert {"2", "1", "0.5", "0", "-0.1"} <= {text.get_text() for text in axes.texts}, "numbers follow"
    assert axes.get_xlabel() == "times & more"


BOTH = (
    figure(*(Panel(f"<i> {k}", {"a&b $x$": [(1e-6, 1e-8), (1e6, 1e3)]}) for k in range(4))),
    BarChart('What "costs" <most>?', "ms", AMOUNTS),
)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("shown", BOTH)
def test_names_are_shown_literally_and_title_is_that_of_the_element(shown):
    root = ElementTree.fromstring(figure_svg(shown))
    assert root.find("{http://www.w3.org/2000/svg}title").text == shown.title
    assert ({"<i> 0", "a&b $x$", "seconds", "error"} if shown is BOTH[0] else set(AMOUNTS) - {"unknown"}) <= set(
        texts(shown)
    )


@pytest.mark.long
def test_text_colour_follows_the_page():
    for shown in BOTH:
        svg = figure_svg(shown)
        written = list(ElementTree.fromstring(svg).iter(TEXT))
        assert written
        assert all("fill: currentColor" in text.get("style") for text in written), "black is what is not named"
        assert not re.search(r"#0[0-9]0101|#000000|: black|: white|#ffffff", svg)


@pytest.mark.long
def test_figures_of_one_page_have_unique_element_ids():
    svg = "".join(figure_svg(shown) for shown in BOTH)
    names = re.findall(r' id="([^"]+)"', svg)
    assert len(set(names)) == len(names)
    used = {*re.findall(r"url\(#([^)]+)\)", svg), *re.findall(r'href="#([^"]+)"', svg)}
    assert used
    assert used <= set(names)


@pytest.mark.long
def test_figure_is_the_same_in_another_process():
    code = (
        "from tactile_maps.studies.base.figures import *; "
        "print(figure_svg(Figure('one', 's', 'm', [Panel('p', {'a': [(1, 2), (3, 4)]})])))"
    )
    labels = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert labels.strip() == figure_svg(Figure("one", "s", "m", [Panel("p", {"a": [(1, 2), (3, 4)]})]))

"""The diagram is well-formed SVG, and points lie where their logarithms say."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from app.studies.figures import Figure, Panel, figure_svg

SVG = "{http://www.w3.org/2000/svg}"


def drawn(*panels, least=1e-9):
    return ElementTree.fromstring(figure_svg(Figure("A & <B>", "seconds", "error", panels, least=least)))


def dots(panel):
    """Centres (k, 2) of each curve's points, by name."""
    found = {}
    for group in panel.findall(f"{SVG}g"):
        centres = [(float(c.get("cx")), float(c.get("cy"))) for c in group.findall(f"{SVG}circle")]
        found[group.find(f"{SVG}title").text] = np.array(centres)
    return found


def panels(root):
    return root.findall(f"{SVG}g")[1:]


def test_equal_factors_are_equal_steps_right_and_down():
    root = drawn(Panel("one", {"ours": [(0.001, 1.0), (0.01, 0.01), (0.1, 0.0001)]}))
    centres = dots(panels(root)[0])["ours"]
    steps = np.diff(centres, axis=0)
    assert steps[0, 0] > 20
    assert steps[0, 1] > 20, "less error is lower"
    np.testing.assert_allclose(steps[0], steps[1], atol=0.2)


def test_a_method_keeps_its_colour_in_all_panels():
    root = drawn(Panel("one", {"a": [(1, 1)], "b": [(2, 2)]}), Panel("two", {"b": [(1, 1)]}))
    first, second = panels(root)
    fills = [{g.find(f"{SVG}title").text: g.get("fill") for g in panel.findall(f"{SVG}g")} for panel in (first, second)]
    assert fills[0]["a"] != fills[0]["b"]
    assert fills[0]["b"] == fills[1]["b"]


def test_no_error_is_drawn_at_the_least_and_what_is_no_number_not_at_all():
    root = drawn(Panel("one", {"ours": [(1, 0.0), (1, np.nan), (1, np.inf), (0, 1), (1, 1e-3)]}), least=1e-3)
    centres = dots(panels(root)[0])["ours"]
    assert len(centres) == 2
    np.testing.assert_allclose(centres[0], centres[1])


@pytest.mark.parametrize("curves", [{}, {"ours": []}, {"ours": [(1, 1)]}])
def test_few_points_or_none_are_no_trouble(curves):
    root = drawn(Panel("one", curves))
    texts = [text.text for text in root.iter(f"{SVG}text")]
    assert "one" in texts
    assert ("nothing measured" in texts) == (not any(curves.values()))


def test_names_are_escaped_and_axes_have_ticks():
    root = drawn(Panel("<i>", {"a&b": [(1e-6, 1e-8), (1e6, 1e3)]}))
    texts = [text.text for text in root.iter(f"{SVG}text")]
    assert {"<i>", "a&b", "seconds", "error"} <= set(texts)
    assert len([text for text in texts if text.startswith("1e") or text.replace(".", "").isdigit()]) >= 4


def test_panels_do_not_lie_on_each_other_nor_outside():
    root = drawn(*[Panel(str(k), {"a": [(1, 1), (2, 2)]}) for k in range(7)])
    places = [tuple(map(float, p.get("transform")[10:-1].split(","))) for p in panels(root)]
    assert len(set(places)) == 7
    assert max(x for x, _ in places) < float(root.get("width")) - 300
    assert max(y for _, y in places) <= float(root.get("height")) - 250


def test_how_sure_a_point_is_stands_upright_through_it_in_its_colour():
    curves, spreads = {"ours": [(0.1, 1.0), (1.0, 0.5)]}, {"ours": [(0.1, 0.7, 2.0), (1.0, 0.5, float("inf"))]}
    (panel,) = panels(drawn(Panel("one", curves, spreads)))
    (line,) = [path for path in panel.findall(f"{SVG}path") if path.get("opacity")]
    x, low, high = (float(number) for number in line.get("d").strip("M").replace("V", ",").split(","))
    dot = dots(panel)["ours"][0]
    assert x == pytest.approx(dot[0], abs=0.1)
    assert high < dot[1] < low, "more is higher, and an endless one is not drawn"
    assert line.get("stroke") == panel.find(f"{SVG}g").get("fill")


def test_a_spread_of_no_curve_is_left_out():
    (panel,) = panels(drawn(Panel("one", {"ours": [(0.1, 1.0)]}, {"theirs": [(0.1, 0.7, 2.0)]})))
    assert not [path for path in panel.findall(f"{SVG}path") if path.get("opacity")]

"""The quality card: what matters first, what it means, and a mark only where something is bad."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication, QLabel

from tactile_maps.maps.evaluation.comparison import TaxelLayout, compare_maps
from tactile_maps.maps.evaluation.distortion import DistortionSummary
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.evaluation.topography import BodyDistances
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.panels.maps.quality_panel import QualityPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tests.widgets.support.samples import leaf_map


@pytest.fixture(scope="module")
def leaves():
    """A small map, what is known of its body, and its quality."""
    made = leaf_map()
    body = BodyDistances(made.skin, sources=4)
    return made, body, measure(made, distances=body)


@pytest.fixture(params=[DARK, LIGHT], ids=["dark", "light"])
def panel(qtbot, request):
    apply_theme(QApplication.instance(), request.param)
    made = QualityPanel()
    qtbot.addWidget(made)
    made.resize(COLUMN_WIDTH, 320)
    made.show()
    return made


def _text(panel, name):
    return panel.findChild(QLabel, f"quality-{name}").text()


def _marked(panel):
    labels = panel.findChildren(QLabel)
    return {label.objectName() for label in labels if label.objectName().endswith("-mark") and label.text()}


@pytest.mark.long
def test_good_map_has_no_warning_mark(panel, leaves):
    panel.show_quality(leaves[2])
    assert _text(panel, "bijective") == "yes"
    assert _text(panel, "angle") == "×1.00"
    assert _text(panel, "torn") == "0.0\u202f%"
    assert _text(panel, "note") == "No issues."
    assert _marked(panel) == set()
    assert not panel.findChild(QLabel, "quality-bijective-b").isVisible()


def test_low_coverage_is_marked(panel, leaves):
    panel.show_quality(leaves[2])
    assert _text(panel, "coverage") == "100.0\u202f%"
    panel.show_quality(replace(leaves[2], coverage=0.12))
    assert _text(panel, "coverage") == "12.0\u202f%"
    assert _marked(panel) == {"quality-coverage-mark"}
    assert _text(panel, "note") == "Above threshold: coverage."


def test_bad_measure_is_marked_and_named(panel, leaves):
    bad = replace(leaves[2], area=DistortionSummary(1.5, 4.0, float("inf")), torn=0.2, torn_pairs=40, pairs=200)
    panel.show_quality(bad)
    assert _marked(panel) == {"quality-area-mark", "quality-torn-mark"}
    assert _text(panel, "note") == "Above threshold: areas, split neighbours."
    mark = panel.findChild(QLabel, "quality-area-mark")
    assert mark.foregroundRole() == QPalette.ColorRole.BrightText
    assert mark.palette().color(QPalette.ColorRole.BrightText).name() == DARK.fault
    assert "Median ×1.50, largest ∞." in mark.parentWidget().toolTip()
    torn = panel.findChild(QLabel, "quality-torn").parentWidget()
    assert "40 of 200 pairs." in torn.toolTip()


@pytest.mark.long
def test_map_that_is_not_one_to_one_is_reported_first(panel, leaves):
    panel.show_quality(replace(leaves[2], bijective=False, flips=3, overlaps=2))
    assert _text(panel, "bijective") == "no"
    assert _text(panel, "note") == "Not bijective: 3 flipped triangles, 2 overlaps."
    assert _marked(panel) == {"quality-bijective-mark", "quality-flips-mark"}


@pytest.mark.long
def test_unknown_measure_is_shown_as_a_dash(panel, leaves):
    panel.show_quality(replace(leaves[2], trustworthiness=None, round_trip_mm=None))
    assert _text(panel, "trustworthiness") == _text(panel, "round_trip_mm") == "–"
    assert _marked(panel) == set()


@pytest.mark.long
def test_every_number_has_a_tooltip(panel, leaves):
    panel.show_quality(leaves[2])
    for label in panel.findChildren(QLabel):
        if label.objectName().startswith("quality-") and label.objectName().endswith(("angle", "stress", "continuity")):
            assert len(label.parentWidget().toolTip()) > 30


@pytest.mark.long
def test_two_maps_are_shown_side_by_side_and_fit(panel, leaves):
    made, body, _ = leaves
    noise = np.random.default_rng(0).normal(scale=0.01, size=made.taxel_points.shape)
    comparison = compare_maps(made, TaxelLayout(made.taxel_points + noise), distances=body)
    panel.show_comparison(comparison)
    for _ in range(3):
        QApplication.processEvents()
    assert panel.findChild(QLabel, "quality-stress-b").isVisible()
    assert _text(panel, "bijective-b") == "–"
    best, other = (panel.findChild(QLabel, f"quality-trustworthiness{side}") for side in ("", "-b"))
    assert float(best.text()) > float(other.text())
    assert best.font().bold()
    assert not other.font().bold()
    assert "A is better in" in _text(panel, "note")
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to it"
    panel.end_comparison()
    assert not panel.findChild(QLabel, "quality-stress-b").isVisible()
    assert not best.font().bold()


@pytest.mark.long
def test_edit_while_two_maps_are_compared_changes_only_the_first(panel, leaves):
    made, body, quality = leaves
    panel.show_comparison(compare_maps(made, TaxelLayout(2 * made.taxel_points[::-1]), distances=body))
    second = _text(panel, "stress-b")
    panel.show_quality(replace(quality, area=DistortionSummary(1.5, 3.0, 4.0)))
    assert _text(panel, "area") == "×3.00"
    assert _text(panel, "stress-b") == second
    assert _text(panel, "note") == "Comparing again…"
    assert not panel.findChild(QLabel, "quality-stress").font().bold(), "it is not known yet which is better"
    panel.end_comparison()
    assert _text(panel, "area") == "×3.00"
    assert _text(panel, "note") == "Above threshold: areas."
    assert not panel.findChild(QLabel, "quality-stress-b").isVisible()


def test_numbers_have_three_digits(panel, leaves):
    panel.show_quality(replace(leaves[2], area=DistortionSummary(1.5, 701.54, 900.0), round_trip_mm=13.456))
    assert _text(panel, "area") == "×702"
    assert _text(panel, "round_trip_mm") == "13.5\u202fmm"


def test_summary_counts_the_bold_measures(panel, leaves):
    """Other measures are compared but not listed."""
    made, body, _ = leaves
    scale = np.array([1.4, 0.9])
    other = replace(made, charts=tuple(replace(chart, plane=chart.plane * scale) for chart in made.charts))
    comparison = compare_maps(made, other, distances=body)
    assert len(comparison.measures) > len(panel._cells)
    panel.show_comparison(comparison)
    labels = [label for label in panel.findChildren(QLabel) if label.objectName() and label.font().bold()]
    second = sum(label.objectName().endswith("-b") for label in labels)
    assert len(labels) - second > 1
    assert _text(panel, "note").startswith(f"A is better in {len(labels) - second} measures, B in {second};")

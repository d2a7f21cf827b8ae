"""Figures of plots: the curves on screen, readable, and an unchanged window."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtWidgets import QApplication

from tactile_maps.session.inputs import PokePressed
from tactile_maps.session.session import Session
from tactile_widgets.dialogs.figures.figure_file import FigurePart, FigureSpec
from tactile_widgets.plots.choice.plot_choice import STANDARD, PlotKey, PlotKind
from tests.support import sessions
from tests.widgets.figures.test_figures import text_boxes, texts_with_boxes
from tests.widgets.support.mouse import left_release, turn_wheel
from tests.widgets.support.window_driver import press_map, run

pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    """The shared window; a figure leaves nothing in it."""
    return window_again


@pytest.fixture(scope="module")
def recording(prepared, tmp_path_factory) -> Path:
    """A second of a session from 0.25 s on, pressed from 0.75 s on."""
    path = tmp_path_factory.mktemp("figures") / "press.mcap"
    session = Session(prepared, scripted=False)
    sessions.run(session, 50)
    sessions.record(session, path, 200, {100: [PokePressed(0, prepared.skin.taxel_point(20))]})
    return path


def view_sizes(window):
    QApplication.processEvents()
    return window.robot_view.size(), window.map_view.size(), window.bottom.size()


def test_figure_of_a_recording_has_its_curves_and_times_and_leaves_the_window_unchanged(window, recording, tmp_path):
    window.live.open_recording(recording)
    before = view_sizes(window)
    picture = window.recording_plots.grab().toImage()
    window.presenters.figure.save(FigurePart.PLOTS, tmp_path / "plots.svg", FigureSpec(60.0, 40.0))
    drawn = (tmp_path / "plots.svg").read_text()
    texts = text_boxes(drawn)
    assert set(window.recording_plots.lanes) | {"0:00.0", "0:00.5"} <= texts.keys()
    assert "now" not in texts
    force, peak = (texts[lane] for lane in window.recording_plots.lanes)
    curves = re.findall(r'<polyline [^>]*points="([^"]*)"', drawn)
    heights = [[float(point.split(",")[1]) for point in curve.split()] for curve in curves if curve.count(",") > 150]
    assert len(heights) == 2, "as vectors"
    assert force.bottom() <= max(heights[0]) < peak.top() < max(heights[1]) < texts["0:00.0"].top()
    assert all(max(height) - min(height) > 10 for height in heights), "readable"
    assert view_sizes(window) == before
    assert window.recording_plots.grab().toImage() == picture
    window.live.replay.leave()


def test_figure_of_a_recording_shows_the_part_on_screen(window, recording, tmp_path):
    window.live.open_recording(recording)
    plots = window.recording_plots
    turn_wheel(plots, QPointF(plots.x_of(0.99), 40), 3)
    window.presenters.figure.save(FigurePart.PLOTS, tmp_path / "plots.svg", FigureSpec(60.0, 40.0))
    times = [float(text[2:]) for text in text_boxes((tmp_path / "plots.svg").read_text()) if text.startswith("0:")]
    assert times
    assert plots.view.start <= min(times) <= max(times) <= plots.view.end
    window.live.replay.leave()


@pytest.fixture
def dialog(window):
    yield plots_dialog(window)
    window.presenters.figure.dialog.reject()


def plots_dialog(window):
    window.action("save_figure").trigger()
    dialog = window.presenters.figure.dialog
    dialog.part.setCurrentIndex(dialog.part.findData(FigurePart.PLOTS))
    return dialog


def show_size(dialog, width, height):
    dialog.width_mm.setValue(width)
    dialog.height_mm.setValue(height)


def smallest_size(dialog):
    return [float(side) for side in re.search(r"Choose at least ([\d.]+) × ([\d.]+) mm", dialog.note.text()).groups()]


@pytest.mark.parametrize("width", [30.0, 50.0, 85.0])
def test_dialog_states_the_smallest_size_at_which_plots_are_readable(window, dialog, tmp_path, width):
    pixel = press_map(window, 70)
    run(window, 0.4)
    window.plots.draw()
    show_size(dialog, width, 20.0)
    assert not dialog.save.isEnabled()
    width, height = smallest_size(dialog)
    show_size(dialog, width, height - 1)
    assert not dialog.save.isEnabled()
    show_size(dialog, width, height)
    assert dialog.save.isEnabled()
    window.presenters.figure.save(FigurePart.PLOTS, tmp_path / "plots.svg", FigureSpec(width, height))
    drawn = (tmp_path / "plots.svg").read_text()
    texts = texts_with_boxes(drawn)
    page = QRectF(*map(float, re.search(r'viewBox="([^"]*)"', drawn)[1].split()))
    outside = [(text, box) for text, box in texts if not page.contains(box)]
    assert not outside
    overlapping = [(one, other) for (one, a), (other, b) in combinations(texts, 2) if a.intersects(b)]
    assert not overlapping
    ends = [box for text, box in texts if text == "now"]
    assert len(ends) == len(window.plots.shown)
    headings = [box for text, box in texts if re.search("[a-z]", text) and text != "now" and text[0] != "−"]
    for end in ends:
        above = [box.bottom() for box in headings if box.bottom() < end.top() and box.left() < end.right()]
        assert end.top() - max(above) > 40, "curves are high"
    left_release(window.map_view.viewport(), pixel)


def test_dialog_states_the_smallest_size_for_the_curves_of_a_recording(window, recording, tmp_path):
    for joint in window.live.prepared.robot.joints[:3]:
        window.plots.add_plot(PlotKey(PlotKind.JOINT, joint.name))
    window.live.open_recording(recording)
    dialog = plots_dialog(window)
    show_size(dialog, 20.0, 20.0)
    assert not dialog.save.isEnabled()
    size = smallest_size(dialog)
    show_size(dialog, *size)
    assert dialog.save.isEnabled()
    dialog.reject()
    window.presenters.figure.save(FigurePart.PLOTS, tmp_path / "plots.svg", FigureSpec(*size))
    drawn = (tmp_path / "plots.svg").read_text()
    assert not any(a.intersects(b) for (_, a), (_, b) in combinations(texts_with_boxes(drawn), 2))
    tops = [text_boxes(drawn)[lane].top() for lane in window.recording_plots.lanes]
    assert len(tops) == 5
    assert np.diff(tops).min() > 40
    window.live.replay.leave()
    for key in set(window.plots.shown_keys) - set(STANDARD):
        window.plots.remove_plot(key)


def test_dialog_mentions_scale_bars_only_for_parts_that_have_them(dialog):
    show_size(dialog, 170.0, 85.0)
    notes = {}
    for part in FigurePart:
        dialog.part.setCurrentIndex(dialog.part.findData(part))
        notes[part] = dialog.note.text().partition("pixels.")[2].strip()
    assert notes == {
        FigurePart.VIEWS: "Robot and map have scale bars.",
        FigurePart.ROBOT: "The robot has a scale bar.",
        FigurePart.MAP: "The map has a scale bar.",
        FigurePart.PLOTS: "",
    }

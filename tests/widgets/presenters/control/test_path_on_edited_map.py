"""Paths and targets in the real window stay at their places on the body when the map is edited, also with undo."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint
from PySide6.QtTest import QTest

from tactile_maps.editing.arrange import move, rotate, scale
from tactile_maps.editing.reflatten import set_lengths
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_maps.session.inputs import ControlChanged, MapEdited
from tactile_widgets.tools.registry import ARRANGE
from tests.widgets.presenters.control.test_control_presenter import click, draw, pixels, settings
from tests.widgets.presenters.files.test_grid_edits import place_grid
from tests.widgets.support.mouse import left_drag
from tests.widgets.support.window_driver import run

ROUNDING = 1e-9


@pytest.fixture
def window(window_again):
    return window_again


def places(window):
    """Places on the body of the points of the path of the session."""
    path = settings(window).path
    map_ = window.live.runner.session.map
    assert path
    return np.array([map_.skin.position(map_.to_body(np.array(point))) for point in path])


def draw_between(window, kind, first, second):
    """Draw a path that two map points define."""
    window.action("draw_path").trigger()
    window.action(f"path_{kind}").trigger()
    ends = window.map_view.map_to_pixels(np.stack([first, second])).round().astype(int)
    start, end = (QPoint(*one) for one in ends.tolist())
    left_drag(window.map_view.viewport(), start, (start + end) / 2, end)
    assert settings(window).path_kind == kind
    assert settings(window).task == "follow_path"


def middle(window, patch):
    return window.editor.document.map.boxes[patch].mean(axis=0)


def arrange(window, by):
    """Drag the first patch by this number of pixels."""
    window.presenters.view.set_tool(ARRANGE)
    view = window.map_view.viewport()
    _, (start, *_) = pixels(window)
    QTest.mouseMove(view, start)
    left_drag(view, start, start + by / 2, start + by)
    run(window, 0.02)


def test_drawn_figure_of_eight_moves_with_its_patch(window):
    centre = middle(window, 0)
    draw_between(window, "lemniscate", centre - (0.03, 0.0), centre + (0.03, 0.0))
    before = places(window)
    first = settings(window).path
    document = window.editor.document
    arrange(window, QPoint(0, 60))
    assert window.editor.document.layout.placements[0] != document.layout.placements[0]
    led = settings(window)
    assert np.abs(np.array(led.path) - first).max() > 0.01
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)
    lines = window.map_view._task.path.lines
    assert window.map_view.picture.document.map.to_body(lines[0].on_map[0]).patch == 0
    assert window.column["controller"].settings == led
    inputs = list(window.live.runner.session.inputs)
    ((tick, _),) = [one for one in inputs if isinstance(one[1], MapEdited)]
    assert [one.settings.path for at, one in inputs if at == tick and isinstance(one, ControlChanged)] == [led.path]

    undo = window.action("undo")
    undo.trigger()
    assert (window.editor.document, settings(window).path) == (document, first)
    assert undo.iconText() == "Undo draw a path"
    window.action("redo").trigger()
    assert settings(window) == led


@pytest.mark.rotating
@pytest.mark.parametrize(
    "edit",
    [
        lambda document: rotate(document, [0], 0.5),
        lambda document: scale(document, [0, 1, 2], 1.5),
    ],
)
@pytest.mark.parametrize("kind", ["raster", "polyline"])
def test_path_and_its_undo_are_exact_after_many_edits(window, kind, edit):
    centre = middle(window, 0)
    draw_between(window, kind, centre - (0.02, 0.02), centre + (0.02, 0.02))
    line = window.map_view._task.path.lines[0].on_map
    map_ = window.editor.document.map
    on_body = [map_.skin.position(map_.to_body(point)) for point in line[:: len(line) - 1]]
    first = settings(window)
    steps = [first]
    for _ in range(3):
        assert window.editor.do("Edit", edit)
        steps.append(settings(window))
    line = window.map_view._task.path.lines[0].on_map
    map_ = window.editor.document.map
    there = [map_.skin.position(map_.to_body(point)) for point in line[:: len(line) - 1]]
    np.testing.assert_allclose(there, on_body, atol=2e-4)
    for step in reversed(steps[:-1]):
        window.action("undo").trigger()
        assert settings(window) == step
    for step in steps[1:]:
        window.action("redo").trigger()
        assert settings(window) == step


def test_path_keeps_its_places_on_a_chart_that_is_computed_again(window, qtbot):
    draw(window)
    before = places(window)
    charts = window.editor.document.charts
    window.editor.ask(lambda document: set_lengths(document, [0], 0.9))
    qtbot.waitUntil(lambda: window.editor.document.charts[0] is not charts[0], timeout=60_000)
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)


def test_path_under_another_patch_returns_to_its_own(window):
    draw(window)
    before = places(window)
    by = middle(window, 1) - middle(window, 0)
    for step in (by, -by + (0.3, 0.2)):
        assert window.editor.do("Move", lambda document, step=step: move(document, [0], step))
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)


def test_path_across_two_patches_is_reported_when_they_part(window):
    draw_between(window, "polyline", middle(window, 0), middle(window, 1))
    before = places(window)
    first = settings(window).path
    shown = window.notification_bar
    shown.clear()
    assert window.editor.do("Move", lambda document: move(document, [1], (0.0, 2.0)))
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)
    assert settings(window).path[0] == first[0]
    assert "of the path is off the skin" in shown.text
    window.action("undo").trigger()
    assert "off the skin" not in shown.text
    assert settings(window).path == first


def test_target_stays_at_its_place(window):
    window.action("set_target").trigger()
    _, (pixel, *_) = pixels(window)
    click(window.map_view.viewport(), pixel)
    before = places(window)
    first = settings(window)
    assert first.task == "hold_point"
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.4))
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)
    assert window.map_view._task.target.patch == 0
    window.action("undo").trigger()
    assert settings(window) == first


def test_undo_of_a_step_on_another_layout_keeps_the_place_on_the_body(window):
    draw(window)
    before = places(window)
    first = settings(window).path
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.4))
    window.action("clear_path").trigger()
    window.editor.go(0)  # as the panel History does
    assert settings(window).path == ()
    window.action("undo").trigger()
    assert settings(window).path == first
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)


@pytest.mark.long
@pytest.mark.usefixtures("scene_cache")
def test_return_to_an_earlier_skin_without_its_edits_keeps_the_place_on_the_body(window):
    draw(window)
    before = places(window)
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.4))
    place_grid(window)
    np.testing.assert_allclose(places(window), before, atol=1e-4)
    window.presenters.tools.skin_steps.go(-1)  # as the panel History does
    run(window, 0.02)
    assert window.editor.history.names == ("Open", "Rotate")
    assert window.editor.history.position == 0
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)
    window.editor.redo()
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)


def test_recording_of_an_edit_under_a_path_is_replayed_identically(window, tmp_path):
    draw(window)
    first = settings(window).path
    window.live.recording.start(tmp_path / "a.mcap")
    run(window, 0.1)
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.4))
    run(window, 0.2)
    led = settings(window)
    assert led.path != first
    window.live.recording.stop()
    player = RecordingPlayer(tmp_path / "a.mcap")
    assert verify(player).identical
    recorded = [act.settings.path for _, act in player.inputs if isinstance(act, ControlChanged)]
    assert recorded[-1] == led.path


def test_cancelled_drag_of_a_target_restores_its_place_on_a_map_edited_meanwhile(window):
    window.action("set_target").trigger()
    _, (pixel, *_) = pixels(window)
    click(window.map_view.viewport(), pixel)
    before = places(window)
    editor = window.presenters.tools.control
    editor.begin("move the target")
    editor.change(path=(tuple(middle(window, 1).tolist()),))
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.4))  # as a computed edit that arrives
    editor.cancel()
    np.testing.assert_allclose(places(window), before, atol=ROUNDING)

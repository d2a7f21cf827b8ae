"""The 2-D map: painting of frames, a press until its effect is painted, and edits of the layout and of a chart."""

from __future__ import annotations

from dataclasses import replace
from itertools import count, cycle

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tactile_maps.control.motion.command import ControlSettings, TaskReport
from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document import MapDocument
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokeReleased
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.views.overlays.task_overlay import ContactTrail
from tactile_widgets.views.overlays.task_overlay_builder import TaskOverlayBuilder
from tests.widgets.support.layered_map_view import layered_map_view


@pytest.fixture(scope="module")
def prepared():
    return prepare(load_scene("arm"))


@pytest.fixture
def view(qtbot, prepared):
    view = layered_map_view(DARK, PressureScale(20.0))
    qtbot.addWidget(view)
    view.resize(720, 720)
    view.show_prepared(prepared)
    view.show()
    qtbot.waitExposed(view)
    return view


@pytest.fixture
def pressed(prepared):
    """Return a session in which a finger has pressed for half a second."""
    session = Session(prepared)
    session.submit(PokePressed(0, prepared.skin.taxel_point(len(prepared.skin) // 2)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    return session


def _dragged(session):
    """Return frames of a finger that moves 30 mm along the map and back."""
    map_ = session.prepared.map
    start = session.frame.regions[0].map_point
    frames = []
    for share in np.concatenate([np.linspace(0, 1, 40), np.linspace(1, 0, 40)]):
        session.submit(PokeMoved(0, map_.to_body(start + [0.03 * share, 0.0])))
        frames.append(session.tick())
    assert frames[0].regions[0].taxels.tolist() != frames[40].regions[0].taxels.tolist()
    return frames


@pytest.mark.parametrize("zoom", [1.0, 6.0], ids=["framed", "zoomed in on the taxels"])
def test_map_frame_shown_and_painted(benchmark, view, prepared, pressed, zoom):
    """Paint frames of a dragged finger, so that consecutive frames differ."""
    view.zoom(zoom, view.pixel_of(prepared.skin.taxel_point(len(prepared.skin) // 2)))
    benchmark.extra_info["taxels"] = len(prepared.skin)
    dragged = cycle(_dragged(pressed))

    def frame():
        view.show_frame(next(dragged))
        view.viewport().repaint()

    benchmark.pedantic(frame, rounds=100, warmup_rounds=5)


@pytest.mark.parametrize("zoom", [1.0, 6.0], ids=["framed", "zoomed in on the taxels"])
def test_map_frame_with_a_task_shown_and_painted(benchmark, view, prepared, pressed, zoom):
    """Paint a frame with a desired path of 90 mm, a target and the contact's track of four seconds."""
    frame = pressed.frame
    overlay = TaskOverlayBuilder()
    overlay.show_map(prepared.map)
    overlay.show_settings(ControlSettings(controller="hybrid", task="follow_path"))
    place = tuple(frame.regions[0].map_point.tolist())
    overlay.show_frame(replace(frame, task=TaskReport(target=frame.regions[0].at, force_goal=3.0, laid_at=place)))
    line = overlay.shown.path.lines[0]
    count = len(line.on_map)
    way = line.on_map, line.on_body, line.normals
    tail = ContactTrail(np.full(count, line.patch), *way, np.linspace(1, 0, count), np.zeros(count, bool))
    task = replace(overlay.shown, tail=tail)
    view.zoom(zoom, view.pixel_of(frame.regions[0].at))
    benchmark.extra_info["corners of the path"] = count

    def show():
        view.show_frame(frame, task=task)
        view.viewport().repaint()

    benchmark.pedantic(show, rounds=100, warmup_rounds=5)


def test_press_on_the_map_until_painted(benchmark, view, prepared):
    """Measure the press event, the tick that handles it, and the painting of the map with its result."""
    session = Session(prepared)
    painted = []
    view.interaction.poke_pressed.connect(lambda at: session.submit(PokePressed(0, at)))
    view.interaction.poke_released.connect(lambda: session.submit(PokeReleased(0)))
    view.painted.connect(painted.append)
    pixel = view.pixel_of(prepared.skin.taxel_point(len(prepared.skin) // 2)).toPoint()

    def press():
        QTest.mousePress(view.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, pixel)
        view.show_frame(session.tick())
        view.viewport().repaint()

    def release():
        QTest.mouseRelease(view.viewport(), Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, pixel)
        for _ in range(5):
            session.tick()

    benchmark.pedantic(press, setup=release, rounds=50, warmup_rounds=3)
    assert painted[-1] == session.frame.tick
    view.interaction.poke_pressed.disconnect()
    view.interaction.poke_released.disconnect()


@pytest.fixture
def document(prepared):
    return MapDocument.of(prepared.map)


def test_map_repaint(benchmark, view, prepared, pressed):
    benchmark.extra_info["taxels"] = len(prepared.skin)
    view.show_frame(pressed.frame)

    def paint():
        view.viewport().update()
        view.viewport().repaint()

    benchmark.pedantic(paint, rounds=100, warmup_rounds=5)


@pytest.mark.parametrize("in_gesture", [True, False], ids=["in the hand", "at rest"])
def test_layout_edit_until_painted(benchmark, view, document, pressed, in_gesture):
    view.show_frame(pressed.frame)
    number = count(1)

    def edited():
        step = next(number)
        return (rotate(move(document, [0], (1e-3 * step, 0.0)), [0], 1e-2 * step),), {}

    def show(edited):
        view.show_document(edited, in_gesture=in_gesture)
        view.viewport().repaint()

    benchmark.extra_info["faces"] = sum(len(chart.faces) for chart in document.charts)
    benchmark.pedantic(show, setup=edited, rounds=60)


@pytest.mark.parametrize("in_gesture", [True, False], ids=["in the hand", "at rest"])
def test_chart_edit_until_painted(benchmark, view, document, pressed, in_gesture):
    view.show_frame(pressed.frame)
    number = count(1)

    def edited():
        chart = document.charts[0]
        x, y = chart.plane.T
        bent = replace(chart, plane=np.stack([x + 1e-3 * next(number) * np.sin(9 * y), y], axis=1))
        return (replace(document, map=replace(document.map, charts=(bent, *document.charts[1:]))),), {}

    def show(edited):
        view.show_document(edited, in_gesture=in_gesture)
        view.viewport().repaint()

    benchmark.extra_info["faces"] = f"{len(document.charts[0].faces)} of the chart"
    view.show_document(edited()[0][0], in_gesture=in_gesture)
    benchmark.pedantic(show, setup=edited, rounds=40 if in_gesture else 10)

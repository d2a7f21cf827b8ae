"""The 2-D map: a frame shown and painted at rest and zoomed in, and a press until the answer is painted."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session.prepare import prepare
from app.session.session import Session
from app.simulation.poke import PokePressed, PokeReleased
from app.simulation.scene_file import load_scene
from widgets.colours import DARK, PressureScale
from widgets.map_view.map_view import MapView


@pytest.fixture(scope="module")
def prepared():
    return prepare(load_scene("arm"))


@pytest.fixture
def view(qtbot, prepared):
    view = MapView(DARK, PressureScale(20.0))
    qtbot.addWidget(view)
    view.resize(720, 720)
    view.show_prepared(prepared)
    view.show()
    qtbot.waitExposed(view)
    return view


@pytest.fixture
def pressed(prepared):
    """A session in which a finger has pressed for half a second."""
    session = Session(prepared)
    session.submit(PokePressed(0, prepared.skin.taxel_point(len(prepared.skin) // 2)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    return session


@pytest.mark.parametrize("zoom", [1.0, 6.0], ids=["framed", "zoomed in on the taxels"])
def test_map_frame_shown_and_painted(benchmark, view, prepared, pressed, zoom):
    view.zoom(zoom, view.pixel_of(prepared.skin.taxel_point(len(prepared.skin) // 2)))
    benchmark.extra_info["taxels"] = len(prepared.skin)

    def frame():
        view.show_frame(pressed.frame)
        view.viewport().repaint()

    benchmark.pedantic(frame, rounds=100, warmup_rounds=5)


def test_press_on_the_map_until_the_answer_is_painted(benchmark, view, prepared):
    """The real press event, the tick that takes it, and the map repainted with its frame."""
    session = Session(prepared)
    painted = []
    view.poke_pressed.connect(lambda at: session.submit(PokePressed(0, at)))
    view.poke_released.connect(lambda: session.submit(PokeReleased(0)))
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
    view.poke_pressed.disconnect()
    view.poke_released.disconnect()

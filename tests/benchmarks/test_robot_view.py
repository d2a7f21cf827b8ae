"""The 3-D view: updating and drawing a frame at three levels of quality, and picking the skin under the pointer."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest

from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.views.robot.robot_view import RobotView


@pytest.fixture(scope="module")
def prepared():
    return prepare(load_scene("arm"))


@pytest.fixture
def view(qtbot, prepared):
    view = RobotView(DARK, PressureScale())
    qtbot.addWidget(view)
    view.resize(900, 700)
    view.show_prepared(prepared)
    view.show()
    qtbot.waitExposed(view)
    yield view
    view.close_view()


@pytest.fixture(scope="module")
def frames(prepared):
    """Return frames of a press, all different."""
    session = Session(prepared, scripted=False)
    session.submit(PokePressed(0, prepared.skin.taxel_point(len(prepared.skin) // 2)))
    frames = [session.tick() for _ in range(60)]
    assert frames[-1].regions
    return frames


@pytest.mark.parametrize("quality", [0.5, 1.0, 2.0])
def test_robot_frame_shown_and_drawn(benchmark, view, prepared, frames, quality):
    faces = sum(len(patch.surface.faces) for patch in prepared.skin.patches)
    benchmark.extra_info["900 x 700, skin faces"] = faces
    coming = iter(frames * 10)

    def frame():
        view.display.show_frame(next(coming))
        view.display.draw_now(quality=quality)
        view.display.canvas.widget.repaint()

    benchmark.pedantic(frame, rounds=60, warmup_rounds=5)


def test_skin_under_the_pointer(benchmark, view, prepared):
    heard = []
    view.interaction.poke_pressed.connect(heard.append)
    pixel = QPointF(view.rect().center()).toPoint()

    def press():
        QTest.mouseClick(view.display.canvas.widget, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, pixel)

    benchmark.pedantic(press, rounds=60, warmup_rounds=5)
    view.interaction.poke_pressed.disconnect(heard.append)

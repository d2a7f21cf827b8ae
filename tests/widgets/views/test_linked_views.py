"""Both views show the same instant, the map first."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.reflatten import set_method
from tactile_maps.editing.seams import propose_seam
from tactile_maps.session.inputs import PokePressed
from tactile_maps.session.session import Session
from tactile_widgets.common.settings import BaseLayer


class Paints(QObject):
    """Counts a widget's paint events."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        self.count += event.type() == QEvent.Type.Paint
        return False


def test_map_is_painted_within_show_frame(window_again, prepared):
    """No event is processed in between, so that the robot view cannot be drawn first."""
    frame = Session(prepared, scripted=False).tick()
    viewport = window_again.map_view.viewport()
    paints = Paints()
    viewport.installEventFilter(paints)
    window_again.views.show_frame(frame)
    viewport.removeEventFilter(paints)
    assert paints.count == 1


def test_both_views_show_the_same_instant(window_again, prepared, qtbot):
    """Frames that the robot view is too slow for are dropped by the map too; finally, both show the newest."""
    views = window_again.views
    session = Session(prepared, scripted=False)
    views.set_paced(on=True)
    views.robot.display.set_automatic(automatic=True)
    session.submit(PokePressed(0, prepared.skin.taxel_point(20)))
    body = views.robot.display
    shown = views.map
    with qtbot.waitSignal(body.drawn):
        views.show_frame(session.tick())
    QApplication.processEvents()
    same = []
    for _ in range(20):
        body._drawing._last_ms = 250.0  # as if the picture had taken so long
        views.show_frame(session.tick())
        QApplication.processEvents()
        same.append(body.actors.shows(shown._frame))
    assert all(same)
    assert not body.actors.shows(session.frame), "much has come meanwhile"
    qtbot.waitUntil(lambda: body.actors._frame.tick == session.frame.tick)
    assert shown._frame.tick == session.frame.tick
    views.set_paced(on=False)
    views.robot.display.set_automatic(automatic=False)


@pytest.mark.long
@pytest.mark.parametrize(
    "edit",
    [
        pytest.param(lambda document: set_method(document, [0], "lscm"), id="other places"),
        pytest.param(lambda document: propose_seam(document, 0), id="more vertices"),
    ],
)
def test_image_of_an_edited_map_is_on_the_body(window_again, edit):
    """A seam doubles vertices, so that the new image fits the new charts only."""
    window = window_again
    window.presenters.view.set_base_layer(BaseLayer.CHECKER)
    before = window.map_view.skin_texture
    window.editor.ask(edit)
    textured = window.robot_view.display.actors.skin._textured
    assert textured is not None
    assert textured._picture is window.map_view.skin_texture is not before

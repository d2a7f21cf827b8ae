"""A layer of one's own, registered once: menus aside, all that reaches it on map and body."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QGraphicsRectItem

from app.editing.arrange import move
from app.editing.document import MapDocument
from app.session.session import Session
from widgets.common.colours import DARK, LIGHT, PressureScale
from widgets.common.settings import OverlayOptions
from widgets.context.linked_views import LinkedViews
from widgets.layers.registry import LAYERS, LayerSpec


class Recorded:
    """Keeps what reaches it."""

    def __init__(self, theme):
        self.got = [theme]

    def set_shown(self, *, shown):
        self.got.append(shown)

    def set_theme(self, theme):
        self.got.append(theme)


class OnMap(Recorded):
    """A square on the map."""

    def __init__(self, document, theme):
        super().__init__(theme)
        self.items = (QGraphicsRectItem(0, 0, 10, 10),)

    def show_document(self, document, shapes):
        self.got.append(document)

    def show_frame(self, frame):
        self.got.append(frame)


class OnBody(Recorded):
    """Nothing, at the links."""

    def __init__(self, plotter, theme, prepared):
        super().__init__(theme)

    def show_frame(self, frame, poses):
        self.got.append((frame, len(poses)))

    def hide(self):
        self.got.append("hidden")


@pytest.fixture
def views(qtbot):
    spec = LayerSpec("grid", "Grid", "", "A grid", on_map=OnMap, on_body=OnBody)
    made = LinkedViews(DARK, PressureScale(), layers=(*LAYERS, spec))
    made.resize(900, 500)
    qtbot.addWidget(made)
    made.show()
    qtbot.waitExposed(made)
    yield made
    made.robot.close_view()


def test_a_layer_needs_one_line(views, prepared):
    views.show_prepared(prepared)
    on_map, on_body = views.map.display.picture.layers["grid"], views.robot.display.scene.layers["grid"]
    assert on_map.got[0] == on_body.got[0] == DARK
    assert on_map.items[0].scene() is views.map.scene()
    frame = Session(prepared).frame
    views.show_frame(frame)
    views.robot.display.draw_now()
    assert on_map.got[-1] is frame
    assert on_body.got[-1] == (frame, len(prepared.robot.links))
    views.set_overlays(OverlayOptions().toggled("grid"))
    assert on_map.got[-1] is True
    assert on_body.got[-2:] == [True, (frame, len(prepared.robot.links))], "at once, though no frame came"
    edited = move(MapDocument.of(prepared.map), [0], (0.05, 0.0))
    views.show_document(edited)
    assert on_map.got[-1] is edited
    views.set_theme(LIGHT)
    assert on_map.got[-1] == on_body.got[-1] == LIGHT
    views.robot.display.scene.morph(0.5)
    assert on_body.got[-1] == "hidden"

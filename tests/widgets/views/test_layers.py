"""The layers that ship change what is seen; one of one's own needs one line: menus aside, all that reaches it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QGraphicsRectItem

from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.pins import add_pin
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.views.layers import LAYERS, LayerSpec
from tactile_widgets.views.linked_views import LinkedViews
from tactile_widgets.views.map.items.map_canvas import MapLayer
from tactile_widgets.views.map.items.map_items import ZOrder
from tactile_widgets.views.robot.actors.robot_actors import BodyLayer
from tests.widgets.support.samples import middle_taxel
from tests.widgets.support.snapshots import pixels

pytestmark = pytest.mark.long


class Recorded:
    """Keeps what reaches it."""

    def __init__(self, scene):
        super().__init__(scene)
        self.got = [scene.theme]

    def set_shown(self, *, shown):
        super().set_shown(shown=shown)
        self.got.append(shown)

    def set_theme(self, theme):
        self.got.append(theme)


class OnMap(Recorded, MapLayer):
    """A square on the map, and a word where it is painted."""

    order = ZOrder.PINS

    def __init__(self, scene):
        super().__init__(scene)
        self.items = (QGraphicsRectItem(0, 0, 10, 10),)

    def show_document(self):
        self.got.append(self.canvas.document)

    def show_frame(self, frame):
        self.got.append(frame)

    def paint(self, painter, view):
        self.got.append("painted")


class OnBody(Recorded, BodyLayer):
    """A layer that draws nothing at the links and records its frames."""

    def show_frame(self, frame, poses):
        self.got.append((frame, len(poses)))

    def hide(self):
        self.got.append("hidden")


SPEC = LayerSpec("grid", "Grid", "", "A grid", on_map=OnMap, on_body=OnBody)


@pytest.fixture
def make_views(qtbot):
    """Both views, seen, with these layers."""
    made = []

    def make(layers):
        views = LinkedViews(DARK, PressureScale(), layers=layers)
        made.append(views)
        views.resize(900, 500)
        qtbot.addWidget(views)
        views.show()
        qtbot.waitExposed(views)
        return views

    yield make
    for views in made:
        views.robot.close_view()


def test_layer_of_one_entry_receives_everything(make_views, prepared):
    views = make_views((*LAYERS, SPEC))
    views.show_prepared(prepared)
    on_map = views.map.picture.layers["grid"]
    on_body = views.robot.display.actors.layers["grid"]
    assert on_map.got[0] == on_body.got[0] == DARK
    assert on_map.items[0].scene() is views.map.scene()
    assert not on_map.items[0].isVisible()
    frame = Session(prepared).frame
    views.show_frame(frame)
    views.robot.display.draw_now()
    assert on_map.got[-1] is frame
    assert on_body.got[-1] == (frame, len(prepared.robot.links))
    views.set_overlays(OverlayOptions().toggled("grid"))
    assert on_map.got[-1] is True
    assert on_map.items[0].isVisible()
    assert on_body.got[-2:] == [True, (frame, len(prepared.robot.links))], "at once, though no frame came"
    edited = move(MapDocument.of(prepared.map), [0], (0.05, 0.0))
    views.show_document(edited)
    assert on_map.got[-1] is edited
    views.map.grab()
    assert "painted" in on_map.got
    views.set_theme(LIGHT)
    assert on_map.got[-1] == on_body.got[-1] == LIGHT
    views.robot.display.actors.morph(0.5)
    assert on_body.got[-1] == "hidden"


def test_views_show_default_layers(make_views, prepared):
    views = make_views((LayerSpec("grid", "Grid", "", "A grid", shown_at_first=True, on_map=OnMap, on_body=OnBody),))
    views.show_prepared(prepared)
    assert views.overlays == OverlayOptions(shown=frozenset({"grid"}))
    assert views.map.picture.layers["grid"].shown
    assert views.robot.display.actors.layers["grid"].shown


def pictures(views):
    """Return the current pixels of map and body."""
    QApplication.processEvents()
    views.robot.display.draw_now()
    return [pixels(view.grab().toImage()).astype(int) for view in (views.map, views.robot)]


@pytest.fixture(scope="module")
def touch(prepared):
    """A frame in which a finger presses, near enough the middle of a patch for its shape to be seen."""
    session = Session(prepared)
    session.submit(PokePressed(0, prepared.skin.taxel_point(middle_taxel(prepared.map, 0))))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    shear = np.outer(0.5 * session.frame.pressures, [1.0, 0.0])
    return replace(session.frame, shear=shear)


@pytest.mark.parametrize("spec", LAYERS, ids=lambda spec: spec.name)
def test_each_layer_is_drawn_only_by_its_entry(make_views, prepared, touch, spec):
    """Seen where its entry has something to draw it, and nowhere when it is taken out of the registry."""
    taxel = middle_taxel(prepared.map, 0)
    document = add_pin(MapDocument.of(prepared.map), prepared.skin.taxel_point(taxel))

    def shown_with(layers):
        views = make_views(layers)
        views.show_prepared(prepared)
        views.show_document(document)
        views.show_frame(touch)
        at = touch.regions[0].at
        views.map.zoom(2.0, views.map.pixel_of(at))
        views.robot.display.look(views.robot.display.actors.viewpoint)
        found = []
        for shown in (frozenset(), frozenset({spec.name}), frozenset()):
            views.set_overlays(OverlayOptions(shown=shown))
            found.append(pictures(views))
        return found

    off, on, off_again = shown_with(LAYERS)
    for number, drawn in enumerate((spec.on_map, spec.on_body)):
        changed = (on[number] != off[number]).any(axis=-1).sum()
        assert changed > 20 if drawn is not None else changed == 0
        np.testing.assert_array_equal(off_again[number], off[number])
    without = shown_with([other for other in LAYERS if other is not spec])
    for number in range(2):
        np.testing.assert_array_equal(without[1][number], without[0][number])

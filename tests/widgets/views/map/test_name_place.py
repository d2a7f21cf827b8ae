"""Names of patches are next to their patches, on no skin where there is room, and no line crosses them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainterPath

from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.views.map.painting import map_painter
from tactile_widgets.views.overlays.callouts import Callout
from tactile_widgets.views.overlays.painting import polygon
from tests.widgets.support.samples import leaf_map, middle_taxel, touched

leaves = cache(leaf_map)
GAP = 0.006
"""Between the boxes of the patches, one above the other [m]; a name is higher on the screen."""


@pytest.fixture(params=[(640, 560), (300, 260)], ids=["large", "small"])
def view(open_map_view, request):
    """The left leaf below the right one."""
    document = MapDocument.of(leaves())
    upper, lower = document.map.boxes[1], document.map.boxes[0]
    by = (upper.mean(axis=0)[0] - lower.mean(axis=0)[0], upper[0, 1] - GAP - lower[1, 1])
    stacked = move(document, [0], by)
    view = open_map_view(*request.param, lambda view: view.show_document(stacked))
    view.frame_all()
    return view


def place_of(view):
    """Painter, marks, map, transform and room of a view."""
    return view._painter, (view.marks, view.picture, view.viewportTransform(), QRectF(view.viewport().rect()))


def areas(view):
    for patch in view.picture.shapes.patches:
        path = QPainterPath()
        path.addPolygon(view.viewportTransform().map(polygon(patch.to_scene(patch.chart.outline))))
        yield path


def test_names_cover_no_skin_and_no_other_caption(view):
    painter, place = place_of(view)
    names = painter.captions(*place).names
    assert [text for _, text in names] == ["left leaf", "right leaf"]
    others = painter.captions(*place).boxes[len(names) :]
    room = place[-1]
    for number, (box, _) in enumerate(names):
        assert room.contains(box)
        assert not any(area.intersects(box.adjusted(1, 1, -1, -1)) for area in areas(view)), "on skin"
        rest = [other for k, (other, _) in enumerate(names) if k != number]
        assert not any(box.intersects(other) for other in (*rest, *others))
        own = next(area for k, area in enumerate(areas(view)) if k == number).boundingRect()
        assert box.intersects(own.adjusted(-4, -4, 4, 4)), "next to its own patch"


def test_name_of_a_patch_with_room_is_above_its_middle(view):
    painter, place = place_of(view)
    (_, upper) = painter.captions(*place).names
    own = [*areas(view)][1].boundingRect()
    assert upper[0].center().x() == pytest.approx(own.center().x(), abs=1.0)
    assert upper[0].bottom() == pytest.approx(own.top() - 2.0, abs=1.5)


def test_name_stays_in_place_while_contacts_appear_and_disappear(view):
    painter, place = place_of(view)
    before = painter.captions(*place).names
    view.show_frame(touched(leaves(), [middle_taxel(leaves(), 0), middle_taxel(leaves(), 1)]))
    painter, place = place_of(view)
    assert painter.captions(*place).names == before


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_leader_line_that_must_cross_a_name_passes_behind_it(view, theme, monkeypatch):
    view.set_theme(theme)
    view.show_frame(touched(leaves(), [middle_taxel(leaves(), 0)]))
    painter, place = place_of(view)
    (name, _) = painter.captions(*place).names[1]
    away = QPointF(-60.0, 0.0)
    words = QRectF(0.0, 0.0, 1.0, 1.0)

    def picture(line):
        monkeypatch.setattr(map_painter, "place_callouts", lambda *_: [Callout(words, line)])
        image = view.grab().toImage()
        values = np.array(image.convertToFormat(image.Format.Format_RGB32).constBits()).reshape(image.height(), -1, 4)
        within = name.adjusted(1, 1, -1, -1).toAlignedRect()
        return values, values[within.top() : within.bottom(), within.left() : within.right()]

    plain, plain_name = picture(None)
    crossed, crossed_name = picture((name.center() + away, name.center() - away))
    assert (crossed != plain).any(), "the line is drawn outside the name"
    np.testing.assert_array_equal(crossed_name, plain_name)


@pytest.mark.parametrize("size", [(150, 140), (180, 200), (210, 230)])
def test_name_is_not_taken_for_that_of_another_patch(open_map_view, prepared, size):
    view = open_map_view(*size, lambda view: view.show_document(MapDocument.of(prepared.map)))
    view.frame_all()
    painter, place = place_of(view)
    outlines = [view.viewportTransform().map(polygon(p.to_scene(p.chart.outline))) for p in view.picture.shapes.patches]
    names = painter.captions(*place).names
    assert len(names) == 3
    for number, (box, _) in enumerate(names):
        away = [min(_distance(box, point) for point in outline) for outline in outlines]
        own = outlines[number].boundingRect()
        above = own.left() - 40 < box.center().x() < own.right() + 40 and box.bottom() <= own.top() + 1
        assert above or away[number] == min(away)


def _distance(box, point):
    dx = max(box.left() - point.x(), point.x() - box.right(), 0.0)
    dy = max(box.top() - point.y(), point.y() - box.bottom(), 0.0)
    return float(np.hypot(dx, dy))

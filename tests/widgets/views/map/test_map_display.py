"""A document that is edited: the camera stays, touch moves with its patch, and only changed images are built."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, QRectF

from tactile_maps.editing.arrange import mirror, move, rotate, scale
from tactile_maps.editing.document import MapDocument, rename_patch, show_patches
from tactile_maps.maps.image_atlas import AtlasTile, ImageAtlas
from tactile_widgets.common.colours import PressureScale
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.views.layers import LAYERS, at_first
from tactile_widgets.views.map import map_view
from tests.widgets.support.arrange_driver import bent
from tests.widgets.support.mouse import left_click
from tests.widgets.support.samples import leaf_map, middle_taxel, touched

leaves = cache(leaf_map)
EDITS = {
    "moved": lambda document: move(document, [0], (0.05, -0.08)),
    "turned": lambda document: rotate(document, [0], 1.1),
    "mirrored": lambda document: mirror(document, [0]),
    "scaled": lambda document: scale(document, [0], 0.6),
    "all": lambda document: scale(mirror(rotate(move(document, [0, 1], (0.1, 0.0)), [0], -2.0), [0]), [0, 1], 1.3),
}


@pytest.fixture
def view(open_map_view):
    return open_map_view(640, 560, lambda view: view.show_document(MapDocument.of(leaves())))


@pytest.fixture
def document(view):
    return view.picture.document


def colour_near(view, taxel):
    """Colour of a pixel near a taxel, where no mark covers the touch."""
    at = view.pixel_of(leaves().skin.taxel_point(taxel)).toPoint() + QPoint(4, 4)
    return view.grab().toImage().pixelColor(at)


def near(one, other):
    """Compare two colours, with a tolerance for the pixel's place in the touch."""
    return max(abs(a - b) for a, b in zip(one.getRgb(), other.getRgb(), strict=True)) < 25


@pytest.mark.long
@pytest.mark.parametrize("edit", EDITS)
def test_touch_moves_with_its_patch_without_a_new_image(view, document, edit):
    taxel = middle_taxel(leaves(), 0)
    tiles = view.picture.atlas.tiles
    quiet = colour_near(view, taxel)
    view.show_frame(touched(leaves(), [taxel], kilopascals=19.0, radius=0.06))
    loud = colour_near(view, taxel)
    assert loud != quiet
    edited = EDITS[edit](document)
    view.show_document(edited)
    assert view.picture.atlas.tiles is tiles
    assert near(colour_near(view, taxel), loud)
    assert not near(quiet, loud)
    for number in range(2):
        at = leaves().skin.taxel_point(middle_taxel(leaves(), number))
        place = view.picture.shapes.frame.to_scene(edited.map.to_map(at))
        assert view.pixel_of(at) == view.viewportTransform().map(QPointF(*place))
        assert view.point_at(view.pixel_of(at)).patch == number
    assert view.marks.contacts[0].at == view.picture.place_of(leaves().skin.taxel_point(taxel))
    assert view.marks.fingers[0].at == view.marks.contacts[0].at


def test_contour_moves_with_its_patch(view, document):
    view.show_frame(touched(leaves(), [middle_taxel(leaves(), 0)], radius=0.06))
    lines = np.array([[line.x1(), line.y1()] for line in view.picture.layers["contours"].marks])
    view.show_document(EDITS["moved"](document))
    moved = np.array([[line.x1(), line.y1()] for line in view.picture.layers["contours"].marks])
    assert len(lines) > 10
    assert moved - lines == pytest.approx(np.full_like(lines, 1) * view.picture.shapes.frame.scale * [0.05, 0.08])


def test_reading_outside_contacts_has_no_contour(view):
    skin = leaves().skin
    frame = touched(leaves(), [middle_taxel(leaves(), 0)], radius=0.06)
    places = skin.positions[skin.patch_of == 0]
    far = int(np.linalg.norm(places - places[frame.pressures[skin.patch_of == 0].argmax()], axis=1).argmax())
    pressures = frame.pressures.copy()
    pressures[np.flatnonzero(skin.patch_of == 0)[far]] = 9000.0
    drawn = []
    for shown in (frame, replace(frame, pressures=pressures)):
        view.show_frame(shown)
        drawn.append([(line.x1(), line.y1()) for line in view.picture.layers["contours"].marks])
    assert len(drawn[0]) > 10
    np.testing.assert_allclose(drawn[1], drawn[0], atol=1e-6)


def test_camera_stays_during_edits_and_fits_the_map_on_request(view, document):
    view.zoom(2.5, QPointF(200, 200))
    still = leaves().skin.taxel_point(middle_taxel(leaves(), 1))
    before = view.pixel_of(still)
    scene = view.scene_point(QPointF(30, 30))
    view.show_document(move(document, [0], (-0.7, 0.4)))
    for point, place in ((view.pixel_of(still), before), (view.scene_point(QPointF(30, 30)), scene)):
        assert np.hypot(point.x() - place.x(), point.y() - place.y()) <= 0.01
    view.pan(3, 0)
    assert view.pixel_of(still).x() - before.x() == pytest.approx(3, abs=0.01)
    view.frame_all()
    room = view.viewport().rect()
    low, high = view.map_to_pixels(view.picture.map.bounds)
    assert room.left() < low[0] < 60 or room.bottom() - 60 < low[1] < room.bottom()
    assert room.contains(QPointF(*low).toPoint())
    assert room.contains(QPointF(*high).toPoint())


def test_distant_patch_fits_into_the_view(view, document):
    view.show_document(move(document, [0], (9e5, 0.0)))
    view.frame_all()
    low, high = view.map_to_pixels(view.picture.map.bounds)
    assert view.viewport().rect().contains(QPointF(*low).toPoint())
    assert view.viewport().rect().contains(QPointF(*high).toPoint())
    assert not view.grab().isNull()
    view.show_document(document)
    view.frame_all()
    assert view.camera.zoom == 1.0


def test_whole_map_stays_in_view_next_to_the_legend_of_a_base_layer(view, document):
    view.frame_all()
    alone = view.viewportTransform().m11()
    view.show_document(move(document, [0], (0.004, 0.0)))  # the camera stays during edits
    view.show_document(document)
    view.set_overlays(replace(at_first(LAYERS), base=BaseLayer.AREA))
    room = QRectF(view.viewport().rect())
    captions = view._painter.captions(view.marks, view.picture, view.viewportTransform(), room)
    boxes = [box for _, box in captions.legends]
    low, high = view.picture.shapes.bounds
    whole = view.viewportTransform().mapRect(QRectF(*low, *(high - low)))
    assert boxes
    assert room.contains(whole)
    assert not any(
        view.picture.hit(place.x(), place.y()) for box in boxes for place in map(view.scene_point, _points(box))
    )
    view.zoom(3.0, whole.center())
    closer = view.viewportTransform()
    view.set_overlays(at_first(LAYERS))
    assert view.viewportTransform() == closer
    view.frame_all()
    assert view.viewportTransform().m11() == alone


def _points(box):
    return [box.topLeft() + QPointF(x * box.width(), y * box.height()) for x in (0, 0.5, 1) for y in (0, 0.5, 1)]


def test_another_skin_is_fitted_to_the_view(view, document, prepared):
    view.zoom(2.5, QPointF(200, 200))
    heard = []
    view.picture_changed.connect(lambda: heard.append(True))
    view.show_document(MapDocument.of(prepared.map))
    assert view.camera.zoom == pytest.approx(1.0)
    assert heard == [True]


def test_hidden_patches_are_not_drawn_hit_or_named(view, document):
    taxel = middle_taxel(leaves(), 0)
    at = leaves().skin.taxel_point(taxel)
    pixel = view.pixel_of(at)
    view.show_frame(touched(leaves(), [taxel]))
    view.show_document(show_patches(document, [0], visible=False))
    picture = view.grab().toImage()
    low, high = view.map_to_pixels(document.map.boxes[0])
    background = picture.pixelColor(int(low[0]) + 1, int(high[1]) + 1)
    for x, y in ((pixel.x(), pixel.y()), (low[0] + 40, (low[1] + high[1]) / 2), ((low[0] + high[0]) / 2, high[1] - 10)):
        assert picture.pixelColor(int(x), int(y)) == background
    assert view.point_at(pixel) is None
    assert view.marks.contacts == ()
    view.set_hover(at)
    assert view.grab().toImage() == picture
    view.show_document(move(document, [1], document.map.boxes[0].mean(axis=0) - document.map.boxes[1].mean(axis=0)))
    assert view.point_at(pixel).patch == 1
    hidden = show_patches(view.picture.document, [1], visible=False)
    view.show_document(hidden)
    assert view.point_at(pixel).patch == 0
    view.show_document(show_patches(hidden, [0], visible=False))
    assert view.point_at(pixel) is None
    view.frame_all()


def test_patch_names_come_from_the_document(view, document):
    before = view.grab().toImage()
    view.show_document(rename_patch(document, 0, "Leaf of mine"))
    assert view.grab().toImage() != before
    assert view.words_for(leaves().skin.taxel_point(0)).startswith("Leaf of mine")


@pytest.fixture
def images_rebuilt(monkeypatch):
    """Disable the cache that all tests share."""
    for owner, name in ((AtlasTile, "of"), (map_view, "ImageAtlas")):
        monkeypatch.setattr(owner, name, getattr(owner, name).__wrapped__)


@pytest.mark.usefixtures("images_rebuilt")
def test_restarted_scene_has_the_same_picture_without_a_new_image(view, prepared):
    view.show_prepared(prepared)
    tiles = view.picture.atlas.tiles
    first = view.grab().toImage()
    view.show_prepared(replace(prepared))
    assert all(old is new for old, new in zip(tiles, view.picture.atlas.tiles, strict=True))
    assert view.grab().toImage() == first


@pytest.mark.long
@pytest.mark.usefixtures("images_rebuilt")
def test_kept_image_is_used_after_another_skin_was_shown(view, prepared):
    image = ImageAtlas(prepared.map)
    other = replace(prepared, map=leaves())
    view.keep_image(image)
    for shown in (prepared, other, prepared):
        view.show_prepared(shown)
    assert all(made is drawn for made, drawn in zip(image.tiles, view.picture.atlas.tiles, strict=True))


@pytest.mark.long
@pytest.mark.usefixtures("images_rebuilt")
def test_images_of_earlier_skins_are_discarded(view, prepared):
    view.show_prepared(prepared)
    tiles = view.picture.atlas.tiles
    for _ in range(3):
        view.show_prepared(replace(prepared, map=leaf_map()))
    view.show_prepared(prepared)
    assert not any(old is new for old, new in zip(tiles, view.picture.atlas.tiles, strict=True))


def test_undone_edit_restores_the_picture(view, document):
    view.show_frame(touched(leaves(), [0, middle_taxel(leaves(), 1)], radius=0.04))
    first = view.grab().toImage()
    for edited in (EDITS["all"](document), bent(document), show_patches(document, [1], visible=False)):
        for in_gesture in (False, True):
            view.show_document(edited, in_gesture=in_gesture)
            assert view.grab().toImage() != first
            view.show_document(document)
            assert view.grab().toImage() == first


def test_dragged_chart_is_a_wireframe_and_only_its_image_is_rebuilt(view, document):
    taxel = middle_taxel(leaves(), 0)
    view.show_frame(touched(leaves(), [taxel], kilopascals=19.0, radius=0.06))
    heard = []
    tiles = view.picture.atlas.tiles
    first = view.grab().toImage()
    view.picture_changed.connect(lambda: heard.append(True))
    for share in (0.05, 0.1):
        held = bent(document, share=share)
        view.show_document(held, in_gesture=True)
    assert view.picture.atlas.tiles is tiles
    assert heard == []
    assert view.grab().toImage() != first
    place = view.picture.shapes.frame.to_scene(held.map.taxel_points[taxel])
    assert view.picture.shapes.taxels[taxel] == pytest.approx(place)
    view.set_scale(PressureScale(200.0))
    assert view.point_at(view.pixel_of(leaves().skin.taxel_point(taxel))) is None
    view.set_scale(PressureScale(20.0))
    net = view.grab().toImage()
    view.show_document(held)
    assert [old is new for old, new in zip(tiles, view.picture.atlas.tiles, strict=True)] == [False, True]
    assert heard == [True]
    assert view.grab().toImage() != net
    assert view.point_at(view.pixel_of(leaves().skin.taxel_point(taxel))).patch == 0
    loud = colour_near(view, taxel)
    view.show_frame(touched(leaves(), []))
    assert colour_near(view, taxel) != loud


def test_flaws_are_marked_and_counted_while_editing(view, document):
    between = document.map.boxes[1].mean(axis=0) - document.map.boxes[0].mean(axis=0)
    assert view.marks.legend is None
    view.show_document(move(document, [0], 0.7 * between), in_gesture=True)
    assert "overlap" in view.marks.legend.flaws[-1]
    view.show_document(document)
    assert view.marks.legend is None


def test_area_stretch_is_updated_after_a_drag(view, document):
    view.set_overlays(replace(at_first(LAYERS), base=BaseLayer.AREA))
    first = view.grab().toImage()
    background = view.picture.background
    enlarged = scale(document, [0], 1.5)
    view.show_document(enlarged, in_gesture=True)
    assert view.picture.background is background
    view.show_document(enlarged)
    assert view.picture.background.stretch.spread.max == pytest.approx(1.5**2)
    view.show_document(document)
    assert view.grab().toImage() == first


@pytest.mark.parametrize("layer", [BaseLayer.CHECKER, BaseLayer.CIRCLES])
def test_textures_move_with_their_patches(view, document, layer):
    view.set_overlays(replace(at_first(LAYERS), base=layer))
    pixels = view.skin_texture.pixels.copy()
    assert len(np.unique(pixels)) > 3
    view.show_document(EDITS["all"](document))
    assert np.array_equal(view.skin_texture.pixels, pixels)


def test_press_during_a_chart_drag_does_not_poke(view, document):
    pokes = []
    view.interaction.poke_pressed.connect(pokes.append)
    view.show_document(bent(document), in_gesture=True)
    pixel = view.pixel_of(leaves().skin.taxel_point(0)).toPoint()
    left_click(view.viewport(), pixel)
    assert pokes == []

"""Base layers, overlay layers and taxel search in the real window."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication, QInputDialog, QLabel

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.pins import add_pin
from tactile_maps.maps.evaluation.distortion import distortion, stretch
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import TaxelIdentity
from tactile_widgets.common.colours import BETWEEN_DOTS, DARK, PressureScale, StretchScale
from tactile_widgets.common.settings import BaseLayer, OverlayOptions, Settings
from tactile_widgets.overlays.taxel_faults import TaxelFaults
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.tools.registry import TOOLS
from tactile_widgets.views.layers import LAYERS, at_first
from tactile_widgets.views.map.items.bijectivity import FlawFinder
from tactile_widgets.views.map.items.map_coordinates import format_three_digits
from tactile_widgets.views.overlays.callouts import LABELLED, more_contacts
from tactile_widgets.window.main_window import MainWindow
from tests.widgets.support.layered_map_view import layered_map_view
from tests.widgets.support.samples import middle_taxel, touched
from tests.widgets.support.snapshots import pixels, shared_share


def look(widget):
    """Return the pixels of a widget."""
    QApplication.processEvents()
    return pixels(widget.grab().toImage()).astype(int)


def body(window):
    """Return the pixels of the robot view after drawing."""
    window.robot_view.display.draw_now()
    return look(window.robot_view)


def colour_at(view, at):
    """Return red, green and blue of the map at a body point."""
    x, y = view.pixel_of(at).toPoint().toTuple()
    colour = QColor(view.viewport().grab().toImage().pixel(x, y))
    return [colour.red(), colour.green(), colour.blue()]


def place(map_, face):
    """Return the centre of a face, numbered over all patches."""
    first = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    patch = int(np.searchsorted(first, face, side="right")) - 1
    return replace(map_.skin.taxel_point(0), patch=patch, face=int(face - first[patch]), weights=(1 / 3, 1 / 3, 1 / 3))


def show(window, taxels, *, kilopascals=25.0, regions=True):
    """Show pressures around these taxels in both views, with the present posture."""
    felt = touched(window.live.prepared.map, taxels, kilopascals=kilopascals)
    present = window.live.runner.session.frame
    kept = felt.regions if regions else ()
    window.views.show_frame(replace(present, pressures=felt.pressures, regions=kept, pokes=()))
    QApplication.processEvents()


def between_taxels(map_, patch):
    """Return a face near the middle of a patch, not under the dot of a taxel, numbered over all patches."""
    middles = map_.uv[patch][map_.charts[patch].faces].mean(axis=1)
    away = np.linalg.norm(middles[:, None] - map_.taxel_points, axis=2).min(axis=1)
    outside = np.linalg.norm(middles - middles.mean(axis=0), axis=1) > 0.3 * np.ptp(middles, axis=0).min()
    return int(np.where(outside, 0, away).argmax()) + sum(len(chart.faces) for chart in map_.charts[:patch])


@pytest.fixture
def window(window_again):
    """Window with the initial overlays."""
    return window_again


@pytest.fixture
def still(window, prepared):
    """Paused window without touch."""
    window.live.set_paused(paused=True)
    show(window, [])
    return window


@pytest.mark.long
@pytest.mark.parametrize(("layer", "measure"), [(BaseLayer.ANGLE, "angle"), (BaseLayer.AREA, "area")])
def test_distortion_layer_shows_measured_values_in_legend_readout_and_colour(still, prepared, layer, measure):
    still.action(f"ground_{layer.value}").trigger()
    view = still.map_view
    legend = view.marks.legend
    spread = stretch(prepared.map, measure).spread
    assert legend.title == layer.title
    text = legend.lines[0].replace("\u202f", " ")
    assert text == f"Median ×{spread.median:.2f}   95 % ×{spread.p95:.2f}   max ×{format_three_digits(spread.max)}"
    assert legend.flaws[0] == "0 flipped triangles, 0 overlaps"
    assert legend.strip
    assert not legend.faulty
    values = getattr(distortion(prepared.map), measure)
    for patch in range(len(prepared.map.charts)):
        face = between_taxels(prepared.map, patch)
        expected = StretchScale().rgb(values[[face]])[0].astype(int)
        assert np.abs(np.array(colour_at(view, place(prepared.map, face))) - expected).max() <= 16
    worst = int(values.argmax())
    assert f"{measure}s ×{format_three_digits(float(values[worst]))}" in view.words_for(place(prepared.map, worst))
    still.action("ground_pressure").trigger()
    assert "×" not in view.words_for(place(prepared.map, worst))


@pytest.mark.long
@pytest.mark.parametrize("ground", [BaseLayer.ANGLE, BaseLayer.AREA, BaseLayer.CHECKER, BaseLayer.CIRCLES])
def test_base_layer_changes_map_and_body_and_can_be_removed(still, ground):
    bare = body(still)
    plain = still.map_view.skin_texture.pixels.copy()
    still.action(f"ground_{ground.value}").trigger()
    assert shared_share(body(still), bare, tolerance=6) < 0.98
    assert (still.map_view.skin_texture.pixels != plain).mean() > 0.1
    still.action("ground_pressure").trigger()
    assert shared_share(body(still), bare, tolerance=6) > 0.999
    assert (still.map_view.skin_texture.pixels == plain).all()


@pytest.mark.long
@pytest.mark.parametrize("ground", list(BaseLayer))
def test_touch_is_the_brightest_on_every_base_layer(still, prepared, ground):
    still.action(f"ground_{ground.value}").trigger()
    at = prepared.skin.taxel_point(middle_taxel(prepared.map, 0))
    before = np.array(colour_at(still.map_view, at))
    show(still, [middle_taxel(prepared.map, 0)], regions=False)
    red, _, blue = colour_at(still.map_view, at)
    assert red - blue > 100 > before[0] - before[2]


@pytest.mark.long
@pytest.mark.parametrize("name", [layer.name for layer in LAYERS if layer.name not in ("friction", "shear")])
def test_layer_is_shown_and_hidden(still, prepared, name):
    still.editor.do("Pin", lambda document: add_pin(document, prepared.skin.taxel_point(40)))
    show(still, [middle_taxel(prepared.map, 0)])
    before = look(still.map_view)
    shown = still.action(f"mark_{name}").isChecked()
    still.action(f"mark_{name}").trigger()
    assert still.action(f"mark_{name}").isChecked() is not shown
    other = look(still.map_view)
    assert (other != before).any(axis=-1).sum() > 20
    still.action(f"mark_{name}").trigger()
    np.testing.assert_array_equal(look(still.map_view), before)


@pytest.mark.long
def test_dots_are_drawn_at_taxels_only(still, prepared):
    bare = body(still)
    still.action("mark_dots").trigger()
    shown = look(still.map_view).reshape(-1, 3)[:, :3]
    for colour in (BETWEEN_DOTS, PressureScale().table[0]):
        assert (np.abs(shown - np.array(colour)).max(axis=1) <= 3).sum() > 1000
    assert shared_share(body(still), bare, tolerance=6) < 0.99
    taxel = middle_taxel(prepared.map, 0)
    show(still, [taxel], regions=False)
    red, _, blue = colour_at(still.map_view, prepared.skin.taxel_point(taxel))
    assert red - blue > 100


@pytest.mark.long
def test_overlays_are_restored_at_the_next_start(still, prepared, backends):
    still.action("ground_circles").trigger()
    still.action("mark_border").trigger()
    still.action("mark_taxel_ids").trigger()
    expected = replace(at_first(LAYERS), base=BaseLayer.CIRCLES).toggled("border").toggled("taxel_ids")
    assert still.views.overlays == expected
    still.settings._store.sync()
    later = MainWindow(Settings(Path(still.settings._store.fileName())), backends=backends)
    assert later.views.overlays == expected
    assert later.action("ground_circles").isChecked()
    assert not later.action("mark_border").isChecked()
    later.live.show_prepared(prepared)
    assert later.map_view.marks.legend.title == "Circles"
    later.close()
    later.deleteLater()


@pytest.mark.parametrize("overlays", [OverlayOptions(), OverlayOptions(BaseLayer.AREA, frozenset({"border", "dots"}))])
def test_overlay_settings_are_restored_from_text(overlays):
    assert OverlayOptions.from_text(overlays.to_text()) == overlays
    for strange in ("", "  ", "sunset dots", "\x00"):
        assert OverlayOptions.from_text(strange) is None


def flipped_map(prepared):
    """Return the map with one inner point moved far over its neighbours."""
    chart = prepared.map.charts[0]
    plane = chart.plane.copy()
    inner = np.linalg.norm(plane - plane.mean(axis=0), axis=1).argmin()
    plane[inner] += [0.03, 0.0]
    return TactileMap(prepared.skin, (replace(chart, plane=plane), *prepared.map.charts[1:]), prepared.map.layout)


@pytest.mark.long
@pytest.mark.parametrize("ground", [BaseLayer.PRESSURE, BaseLayer.ANGLE])
def test_flipped_triangles_are_marked_red_and_counted(qtbot, small_arm, ground):
    view = layered_map_view(DARK, PressureScale())
    qtbot.addWidget(view)
    view.resize(700, 600)
    view.set_overlays(replace(at_first(LAYERS), base=ground))
    spoiled = flipped_map(small_arm)
    found = FlawFinder().of(MapDocument.of(spoiled)).flips
    assert len(found) > 0
    reds = []
    for map_ in (small_arm.map, spoiled):
        view.show_prepared(replace(small_arm, map=map_))
        view.show()
        qtbot.waitExposed(view)
        shown = look(view)
        # Where the view has the map, by its taxels; then half way from each flip's middle to its corners, not its dot.
        fit = np.linalg.lstsq(np.c_[map_.taxel_points, np.ones(len(map_.skin))], view.taxel_pixels(), rcond=None)[0]
        inner = 0.5 * (found + found.mean(axis=1, keepdims=True)).reshape(-1, 2)
        columns, rows = np.rint(np.c_[inner, np.ones(len(inner))] @ fit).astype(int).T
        reds.append(shown[rows, columns, 0] - shown[rows, columns, 1])
    assert reds[0].max() < 40
    assert np.median(reds[1]) > 60
    noun = "triangle" if len(found) == 1 else "triangles"
    legend = view.marks.legend
    assert legend.flaws[-1].startswith(f"{len(found)} flipped {noun}")
    assert legend.faulty
    if ground is BaseLayer.PRESSURE:
        assert legend.title == "Not bijective"


def identified(prepared):
    """Return the scene with hardware ids as on a robot: descending, modules of twelve."""
    start = 87012
    patches = []
    for patch in prepared.skin.patches:
        ids = start - np.arange(len(patch.taxels))
        identity = TaxelIdentity(ids, ids // 12, ids % 12)
        patches.append(replace(patch, taxels=replace(patch.taxels, identity=identity)))
        start -= len(patch.taxels)
    skin = replace(prepared.skin, patches=tuple(patches))
    return replace(prepared, skin=skin, map=replace(prepared.map, skin=skin))


@pytest.mark.long
def test_taxel_is_found_by_its_hardware_id(window, prepared):
    named = identified(prepared)
    window.live.show_prepared(named)
    window.live.set_paused(paused=True)
    taxel = middle_taxel(prepared.map, 1)
    window.action("find_taxel").trigger()
    box = window.findChild(QInputDialog, "find-taxel")
    box.setTextValue(str(87012 - taxel))
    box.accept()
    assert window.views.selection.taxels.tolist() == [taxel]
    module, channel = divmod(87012 - taxel, 12)
    name = f"id {87012 - taxel}, module {module}, channel {channel} (taxel {taxel})"
    assert window.statusBar().currentMessage() == f"Found {name}"
    assert name[1:] in window.findChild(QLabel, "selection-count").text()
    at = named.skin.taxel_point(taxel)
    for view in (window.map_view, window.robot_view):
        size = view.viewport().size() if view is window.map_view else view.size()
        away = view.pixel_of(at) - QPointF(size.width() / 2, size.height() / 2)
        assert max(abs(away.x()), abs(away.y())) < 3, "in the middle of both views"
    assert window.map_view.camera.zoom > 1
    assert not window.robot_view.hidden(np.array([taxel]))[0], "on the side that faces the eye"
    window.map_view.set_faults(TaxelFaults(np.arange(len(named.skin)) == taxel))
    words = window.map_view.words_for(at)
    assert f"{name}, dead" in words
    assert window.map_view.marks.faults[0][1] == f"1 taxel dead: module {module} (channel {channel})"
    window.editor.select([1])
    window.action("hide_patches").trigger()
    window.presenters.view.find_taxel(str(87012 - taxel))
    hidden = named.skin.patches[1].name
    assert window.statusBar().currentMessage().endswith(f"hidden on the map: {hidden} (Edit > Show all patches)")
    camera = window.map_view.camera
    window.presenters.view.find_taxel("5/5")
    assert window.views.selection.taxels.tolist() == [taxel], "unchanged"
    assert window.map_view.camera == camera
    assert "Unknown taxel" in window.notification_bar.text


@pytest.mark.parametrize("name", [spec.kind.name for spec in TOOLS if spec.kind.edits][:1])
def test_edit_tool_shows_the_tab_of_the_map(window, name):
    window.action(name).trigger()
    assert window.column.tab is PanelTab.MAP


def test_only_the_strongest_contacts_have_captions(still, prepared):
    taxels = [int(middle) for patch in range(len(prepared.skin.patches)) for middle in spread(prepared, patch)]
    show(still, taxels)
    still.robot_view.display.draw_now()
    captions = still.robot_view.display.overlay._captions
    assert captions.contacts == len(taxels) > LABELLED
    assert 0 < len(captions.forces) <= LABELLED
    assert more_contacts(captions.contacts) == (f"+{len(taxels) - LABELLED} more contacts",)


def spread(prepared, patch):
    """Return four taxels of a patch that are far from each other on the map."""
    taxels = np.flatnonzero(prepared.skin.patch_of == patch)
    places = prepared.map.taxel_points[taxels]
    return [taxels[int(np.argmax(places @ side))] for side in ([1.0, 0.2], [-1.0, 0.2], [0.1, 1.0], [0.1, -1.0])]


@pytest.mark.parametrize("size", [(1107, 700), (1400, 900)])
@pytest.mark.parametrize("layer", [BaseLayer.PRESSURE, BaseLayer.AREA])
def test_captions_cover_no_other_caption(still, prepared, size, layer):
    still.resize(*size)
    still.presenters.view.set_base_layer(layer)
    taxels = [int(middle) for patch in range(len(prepared.skin.patches)) for middle in spread(prepared, patch)]
    show(still, taxels)
    still.robot_view.display.draw_now()
    view = still.map_view
    overlay = still.robot_view.display.overlay
    place = view.viewportTransform(), QRectF(view.viewport().rect())
    on_map = [callout.box for callout, _ in view._painter.callouts(view.marks, view.picture, *place)]
    on_body = [callout.box for _, callout in overlay.callouts()]
    fixed = view._painter.captions(view.marks, view.picture, *place).boxes
    assert not any(one.intersects(other) for number, one in enumerate(fixed) for other in fixed[:number])
    for callouts, others in ((on_map, fixed), (on_body, overlay.caption_boxes())):
        assert len(callouts) > 1
        for number, box in enumerate(callouts):
            assert not any(box.intersects(other) for other in (*others, *callouts[:number]))

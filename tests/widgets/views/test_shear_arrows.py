"""Arrows of shear: the same tractions in both views, in pixels, merged where taxels are close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.views.linked_views import LinkedViews
from tactile_widgets.views.overlays.shear_arrows import ARROW_PX
from tests.widgets.support.samples import middle_taxel, touched
from tests.widgets.support.snapshots import pixels


@pytest.fixture(scope="module")
def shared_views(qapp):
    """The views of all tests, and their initial overlays."""
    views = LinkedViews(DARK, PressureScale(maximum=40.0))
    views.resize(900, 500)
    views.show()
    assert QTest.qWaitForWindowExposed(views)
    yield views, views.overlays
    views.robot.close_view()
    views.close()
    views.deleteLater()


@pytest.fixture
def show(shared_views):
    """Show a frame in the views, whatever the previous test has shown."""
    views, overlays = shared_views

    def show(prepared, frame):
        views.set_overlays(overlays)
        views.robot.display.actors.hidden = frozenset()
        views.show_prepared(prepared)
        views.frame_all()
        views.show_frame(frame)
        views.robot.display.look_at(prepared.skin.taxel_point(frame.regions[0].taxels[0]))
        draw(views)
        return views

    return show


def draw(views):
    QApplication.processEvents()
    views.robot.display.draw_now()


def with_shear(prepared, taxel, traction, *, radius=0.03):
    """A touch with the same traction (2,) [Pa] on all taxels, along the axes of ``taxel``."""
    frame = touched(prepared.map, [taxel], radius=radius)
    axes = taxel_frames(prepared.map)
    shear = axes[:, :2] @ (np.asarray(traction) @ axes[taxel, :2])
    posture = np.asarray(prepared.robot.home)
    return replace(frame, shear=shear, posture=posture)


def map_arrows(views):
    return views.map.picture.layers["shear"].ends(views.map.viewportTransform())


def body_arrows(views):
    actors = views.robot.display.actors
    return actors.arrows(actors.viewpoint, views.robot.display.size)


def test_arrows_on_both_views_show_traction_of_pressed_taxels_in_one_scale(show, prepared):
    taxel = middle_taxel(prepared.map, 0)
    frame = with_shear(prepared, taxel, [20e3, 0.0])
    views = show(prepared, frame)
    on_map = map_arrows(views)
    steps = on_map[:, 1] - on_map[:, 0]
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), ARROW_PX, rtol=0.05)
    assert (steps[:, 0] > 0.9 * ARROW_PX).all(), "t1 is the x axis of the map"
    places = views.map.taxel_pixels()[frame.pressures >= 1e3]
    assert (np.linalg.norm(on_map.mean(axis=1)[:, None] - places, axis=2).min(axis=1) < ARROW_PX).all()
    on_body = body_arrows(views)
    lengths = np.linalg.norm(on_body[:, 1] - on_body[:, 0], axis=1)
    assert 0.8 * ARROW_PX < lengths.max() < 1.05 * ARROW_PX
    assert views.map.marks.layers[0].texts == views.robot.display.actors.legends[0].texts
    assert views.map.marks.layers[0].texts[0].startswith("20")
    shown = [pixels(view.grab().toImage()) for view in (views.map, views.robot)]
    views.set_overlays(views.overlays.toggled("shear"))
    draw(views)
    assert views.map.marks.layers == ()
    for view, before in zip((views.map, views.robot), shown, strict=True):
        assert (pixels(view.grab().toImage()) != before).any(axis=-1).sum() > 50


def test_close_arrows_merge_when_zoomed_out(show, prepared):
    taxel = middle_taxel(prepared.map, 0)
    frame = with_shear(prepared, taxel, [20e3, 0.0], radius=0.1)
    views = show(prepared, frame)
    views.map.zoom(8.0, views.map.pixel_of(prepared.skin.taxel_point(taxel)))
    single = map_arrows(views)
    assert len(single) > 10
    views.map.zoom(1 / 16, views.map.pixel_of(prepared.skin.taxel_point(taxel)))
    merged = map_arrows(views)
    assert 1 <= len(merged) < len(single) / 2


def test_one_axis_frame_has_neither_arrows_nor_legend(show, prepared):
    taxel = middle_taxel(prepared.map, 0)
    views = show(prepared, with_shear(prepared, taxel, [20e3, 0.0]))
    views.show_frame(replace(touched(prepared.map, [taxel]), posture=np.asarray(prepared.robot.home)))
    draw(views)
    assert not len(map_arrows(views))
    assert not len(body_arrows(views))
    assert views.map.marks.layers == views.robot.display.actors.legends == ()


def test_link_in_front_hides_arrows_on_the_body(show, prepared):
    taxel = middle_taxel(prepared.map, 0)
    views = show(prepared, with_shear(prepared, taxel, [20e3, 0.0]))
    assert len(body_arrows(views))
    layer = views.robot.display.actors.layers["shear"]
    links = [number for number, link in enumerate(prepared.robot.links) if link.mesh is not None]
    other = next(number for number in links if number != layer._links[taxel])
    poses = layer._poses.copy()
    eye = views.robot.display.actors.viewpoint.eye
    at = poses[layer._links[taxel]] @ [*layer._positions[taxel], 1.0]
    mesh = prepared.robot.links[other].mesh
    poses[other, :3, 3] = 0.5 * (eye + at[:3]) - poses[other, :3, :3] @ mesh.vertices.mean(axis=0)
    layer._poses = poses
    assert not len(body_arrows(views))
    views.robot.display.actors.hidden = frozenset({other})
    assert len(body_arrows(views)), "a link that the user hid is not in front"


def test_friction_in_use_is_shown_on_pressed_taxels_with_a_mark_where_they_slip(show, prepared):
    taxel = middle_taxel(prepared.map, 0)
    frame = with_shear(prepared, taxel, [20e3, 0.0])
    (region,) = frame.regions
    state = ContactShear((1.0, 0.0, 0.0), 0.0, 0.5, 1.0, Slip.STICKING, 0.5, estimated=False)
    own = region.taxels[frame.pressures[region.taxels] > 0]
    shear = np.zeros_like(frame.shear)
    shear[own, 0] = 0.5 * 0.4 * frame.pressures[own]
    shear[own[0], 0] = 0.5 * frame.pressures[own[0]]
    frame = replace(frame, regions=(replace(region, shear=state),), shear=shear)
    views = show(prepared, frame)
    assert all("friction" not in text for legend in views.map.marks.layers for text in legend.texts)
    before = [pixels(view.grab().toImage()) for view in (views.map, views.robot)]
    views.set_overlays(views.overlays.toggled("friction"))
    draw(views)
    for view, bare in zip((views.map, views.robot), before, strict=True):
        assert (pixels(view.grab().toImage()) != bare).any(axis=-1).sum() > 50
    legends = views.robot.display.actors.legends
    assert [legends[0].texts[0], legends[0].texts[-1]] == ["0\u202f% of the friction", "slips"]
    assert legends[0].texts == views.map.marks.layers[0].texts
    discs = views.robot.display.actors.layers["friction"]
    assert sorted(np.concatenate(discs._discs._shown)) == sorted(own)
    assert np.concatenate(discs._rings._shown).tolist() == [own[0]]
    views.show_frame(replace(touched(prepared.map, [taxel]), posture=np.asarray(prepared.robot.home)))
    draw(views)
    assert views.map.marks.layers == views.robot.display.actors.legends == ()


@pytest.mark.long
def test_shear_of_sliding_ball_points_the_same_way_on_map_and_body(show):
    prepared = prepare(load_scene("slip"))
    session = Session(prepared)
    while session.frame.time < 2.5:
        session.tick()
    frame = session.frame
    views = show(prepared, frame)
    total = np.zeros(3)
    axes = taxel_frames(prepared.map)
    total += np.einsum("kij,ki,k->j", axes[:, :2], frame.shear, prepared.skin.areas)
    np.testing.assert_allclose(total, frame.regions[0].shear.force, atol=0.1)
    display = views.robot.display
    pose = display.actors.poses[prepared.robot.link_index[frame.regions[0].link]]
    at = pose[:3, :3] @ frame.regions[0].link_position + pose[:3, 3]
    tip = at + 1e-3 * pose[:3, :3] @ total
    across = np.diff(display.actors.viewpoint.pixels(np.stack([at, tip]), display.size), axis=0)[0]
    ends = body_arrows(views)
    longest = ends[np.argmax(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))]
    step = longest[1] - longest[0]
    assert step @ across > 0.9 * np.linalg.norm(step) * np.linalg.norm(across)

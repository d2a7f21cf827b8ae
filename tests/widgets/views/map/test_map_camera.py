"""The camera's promises: what is under the pointer stays there, and nothing gets lost."""

from __future__ import annotations

import pytest

from tactile_widgets.views.map.items.map_coordinates import HIGHEST_ZOOM, LOWEST_ZOOM, MARGIN_PX, MapCamera

VIEW = (700.0, 500.0)


def test_framing_shows_all_with_a_margin_and_keeps_the_aspect():
    camera = MapCamera.framing((1000.0, 400.0))
    left, top = camera.to_scene((0.0, 0.0), VIEW)
    assert left * camera.scale(VIEW) == pytest.approx(-MARGIN_PX)
    assert top < 0
    assert camera.to_scene((350.0, 250.0), VIEW) == pytest.approx((500.0, 200.0))


@pytest.mark.parametrize("factor", [1.2, 5.0, 0.7])
def test_zoom_keeps_the_point_under_the_pointer(factor):
    camera = MapCamera.framing((1000.0, 700.0)).zoomed(3.0, (350.0, 250.0), VIEW)
    pixel = (400.0, 200.0)
    before = camera.to_scene(pixel, VIEW)
    after = camera.zoomed(factor, pixel, VIEW)
    assert after.zoom == pytest.approx(3.0 * factor)
    assert after.to_scene(pixel, VIEW) == pytest.approx(before)


def test_zoom_has_ends():
    camera = MapCamera.framing((1000.0, 700.0))
    assert camera.zoomed(1e9, (350.0, 250.0), VIEW).zoom == HIGHEST_ZOOM
    assert camera.zoomed(1e-9, (350.0, 250.0), VIEW).zoom == LOWEST_ZOOM


def test_panning_follows_the_hand():
    camera = MapCamera.framing((1000.0, 700.0)).zoomed(4.0, (350.0, 250.0), VIEW)
    held = camera.to_scene((300.0, 260.0), VIEW)
    assert camera.panned(20.0, -10.0, VIEW).to_scene((320.0, 250.0), VIEW) == pytest.approx(held)


def test_the_map_cannot_be_lost():
    camera = MapCamera.framing((1000.0, 700.0)).panned(1e6, -1e6, VIEW)
    assert camera.centre == (0.0, 700.0)


def test_a_resize_keeps_the_centre_and_the_zoom():
    camera = MapCamera.framing((1000.0, 700.0)).zoomed(4.0, (100.0, 100.0), VIEW)
    for view in ((200.0, 900.0), (1400.0, 1000.0)):
        assert camera.to_scene((view[0] / 2, view[1] / 2), view) == pytest.approx(camera.centre)
    assert camera.scale((1400.0 - 2 * MARGIN_PX, 1000.0)) > camera.scale(VIEW)


def test_no_viewport_is_too_small():
    assert MapCamera.framing((1000.0, 700.0)).scale((0.0, 0.0)) > 0

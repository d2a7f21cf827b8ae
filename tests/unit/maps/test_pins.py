"""The patch under the hand: pins in and out, moved anywhere, refused by name, never a flip."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.bijective import flipped
from app.maps.chart import Chart
from app.maps.flatten import flatten
from app.maps.methods.table import METHODS
from app.maps.newton import minimise
from app.maps.pin import Pin
from app.maps.pins import WHOLE, PinnedPatch
from tests.numerics.map_surfaces import sheet
from tests.unit.maps.pinned_patches import at, dome, far_points, pinned, waves


def dragged(patch, number, path):
    """Frames along ``path``; every one checked."""
    faces = patch._chart.faces
    for place in path:
        patch.move(number, place)
        plane = patch.frame()
        assert np.isfinite(plane).all()
        assert not flipped(plane, faces).any()
    return patch


def line(start, end, count=20):
    return start + np.linspace(0, 1, count)[:, None] * (np.asarray(end) - start)


def test_a_pin_goes_in_where_it_is_and_nothing_moves():
    surface, chart = waves()
    patch, numbers, places = pinned(surface, chart)
    assert list(patch.pins) == numbers == [0, 1, 2, 3, 4]
    assert patch.lag < 1e-9
    np.testing.assert_allclose([pin.place for pin in patch.pins.values()], places, atol=1e-12)
    assert np.abs(patch.frame() - chart.plane).max() < 0.01 * np.sqrt(surface.area)


def test_a_dragged_pin_is_followed_within_a_frame():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    end = places[0] + [0.01, 0.0]
    dragged(patch, numbers[0], line(places[0], end))
    assert patch.lag < 1e-3 * np.sqrt(surface.area)
    np.testing.assert_allclose(patch.plane[far_points(chart.plane, 1)[0]], end, atol=1e-4)
    for _ in range(10):
        patch.frame()
    assert patch.still


def test_after_a_few_still_frames_the_energy_is_within_a_hundredth_of_the_least():
    for surface, chart in (dome(), waves()):
        patch, numbers, places = pinned(surface, chart)
        size = np.ptp(chart.plane, axis=0).min()
        dragged(patch, numbers[0], line(places[0], places[0] + [0.15 * size, 0.1 * size]))
        for _ in range(5):
            patch.frame()
        *_, least = minimise(patch._pinned(), patch._follower.plane, tolerance=1e-9)
        assert least.energy <= patch.energy <= 1.01 * least.energy


def test_back_where_it_was_the_energy_is_what_it_was():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    for _ in range(20):
        patch.frame()
    before, plane = patch.energy, patch.plane
    dragged(patch, numbers[0], line(places[0], places[0] + [0.01, 0.01]))
    assert patch.energy > before + 0.01
    dragged(patch, numbers[0], line(places[0] + [0.01, 0.01], places[0]))
    for _ in range(20):
        patch.frame()
    assert patch.energy == pytest.approx(before, rel=1e-6)
    assert np.abs(patch.plane - plane).max() < 1e-3 * np.sqrt(surface.area)


def test_a_pin_taken_out_lets_go():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.01))
    held = patch.energy
    patch.remove(numbers[0])
    assert list(patch.pins) == numbers[1:]
    for _ in range(20):
        patch.frame()
    assert patch.energy < held - 0.01
    assert patch.add(at(chart, far_points(chart.plane, 1)[0])) == 5, "a number is never used again"


def test_one_pin_moves_all_of_the_map():
    surface, chart = dome()
    patch, (number,), places = pinned(surface, chart, 1)
    dragged(patch, number, line(places[0], places[0] + 0.05))
    for _ in range(20):
        patch.frame()
    assert patch.energy < 4.16
    np.testing.assert_allclose(patch.plane.mean(axis=0), chart.plane.mean(axis=0) + 0.05, atol=0.01)


def test_without_pins_frames_are_free():
    surface, chart = dome()
    patch = PinnedPatch(surface, chart)
    assert patch.lag == 0.0
    patch.frame()
    assert patch.energy < 4.16


@pytest.mark.parametrize("method", METHODS)
def test_any_methods_map_can_be_taken_in_hand(method):
    surface, _ = dome()
    chart = flatten(surface, method=method)
    patch, numbers, places = pinned(surface, chart)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.008))
    for _ in range(10):
        patch.frame()
    assert patch.lag < 1e-3


@pytest.mark.parametrize("lengths", [0.0, 0.5, 1.0])
def test_at_any_place_of_the_slider(lengths):
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart, lengths=lengths)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.01))
    assert patch.lag < 1e-3 * np.sqrt(surface.area)


class TestWishesThatContradictEachOther:
    """Finite, never flipped, and told."""

    def test_swapped(self):
        surface, chart = dome()
        patch, (first, second, *_), places = pinned(surface, chart)
        for here, there in zip(line(places[0], places[1]), line(places[1], places[0]), strict=True):
            patch.move(second, there)
            dragged(patch, first, [here])

    @pytest.mark.parametrize("far", [0.2, 1.0, 5.0])
    def test_dragged_far_outside(self, far):
        surface, chart = dome()
        patch, numbers, places = pinned(surface, chart)
        dragged(patch, numbers[0], [places[0] + [far, 0.0]] * 30)
        assert patch.lag > 0, "what cannot be is told"

    def test_onto_another(self):
        surface, chart = dome()
        patch, numbers, places = pinned(surface, chart)
        dragged(patch, numbers[0], [*line(places[0], places[1]), *[places[1]] * 20])

    def test_from_one_side_to_the_other_at_once_and_back(self):
        surface, chart = waves()
        patch, numbers, places = pinned(surface, chart)
        dragged(patch, numbers[0], [places[1] + 0.01, places[2], places[3] - 0.02, *[places[0]] * 30])
        assert patch.lag < 1e-3 * np.sqrt(surface.area)


class TestWhatIsRefused:
    """By name, with all as it was."""

    @pytest.mark.parametrize("place", [(np.nan, 0.0), (0.0, np.inf), (1e3, 0.0), (-1e300, 1.0)])
    def test_a_place_that_is_none(self, place):
        surface, chart = dome()
        patch, numbers, places = pinned(surface, chart)
        with pytest.raises(MapError, match="no place near the map"):
            patch.move(numbers[0], place)
        with pytest.raises(MapError, match="no place near the map"):
            patch.add(SurfacePoint(0, 7, (0.4, 0.3, 0.3)), place)
        assert list(patch.pins) == numbers
        np.testing.assert_allclose([pin.place for pin in patch.pins.values()], places, atol=1e-12)

    @pytest.mark.parametrize(
        ("face", "weights"),
        [(-1, (1, 0, 0)), (10**6, (1, 0, 0)), (0, (2, -1, 0)), (0, (0.2, 0.2, 0.2)), (0, (np.nan, 0.5, 0.5))],
    )
    def test_a_place_that_is_not_on_the_patch(self, face, weights):
        with pytest.raises(MapError, match="not on the patch"):
            PinnedPatch(*dome()).add(SurfacePoint(0, face, weights))

    def test_a_second_pin_at_the_same_place_of_the_body(self):
        surface, chart = dome()
        patch, _, _ = pinned(surface, chart)
        vertex = far_points(chart.plane, 1)[0]
        for face in np.flatnonzero((chart.faces == vertex).any(axis=1)):
            with pytest.raises(MapError, match="a pin already"):
                patch.add(SurfacePoint(0, int(face), tuple((chart.faces[face] == vertex).astype(float))))

    def test_a_pin_that_is_not_there(self):
        patch = PinnedPatch(*dome())
        with pytest.raises(MapError, match="no such pin"):
            patch.move(0, (0.0, 0.0))
        with pytest.raises(MapError, match="no such pin"):
            patch.remove(3)

    def test_a_slider_past_its_end(self):
        with pytest.raises(MapError, match="slider"):
            PinnedPatch(*dome(), lengths=1.5)

    def test_another_surfaces_chart(self):
        with pytest.raises(MapError, match="another surface"):
            PinnedPatch(dome()[0], waves()[1])

    def test_a_map_with_flips(self):
        surface, chart = dome()
        with pytest.raises(MapError, match="flipped"):
            PinnedPatch(surface, chart, plane=chart.plane * [-1, 1])


def test_pins_and_plane_of_before_can_be_given():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.01))
    again = PinnedPatch(surface, chart, pins=tuple(patch.pins.values()), plane=patch.plane)
    assert again.energy == pytest.approx(patch.energy, rel=1e-9)
    assert list(again.pins.values()) == list(patch.pins.values())
    assert all(isinstance(pin, Pin) for pin in again.pins.values())


class TestLargePatches:
    """Followed by a coarse stand-in, settled in full."""

    def test_they_are_followed_and_settled_as_small_ones_are(self):
        surface, chart = waves()
        small, numbers, places = pinned(surface, chart)
        large, _, _ = pinned(surface, chart, whole=1000)
        assert large.by_proxy
        assert not small.by_proxy
        for patch in (small, large):
            dragged(patch, numbers[0], line(places[0], places[0] + 0.015))
        assert large.lag < 2e-3 * np.sqrt(surface.area)
        exact, refined = small.settle(), large.settle()
        np.testing.assert_allclose(refined.plane, exact.plane, atol=2e-3 * np.sqrt(surface.area))
        assert large.by_proxy
        assert large.lag < 1e-3 * np.sqrt(surface.area)

    def test_where_no_stand_in_can_be_made_they_are_followed_whole(self):
        strip = sheet(7000, 1, width=1.0, height=0.0001)
        none = np.zeros((0, 2), dtype=np.int64)
        chart = Chart(strip.faces, strip.vertices[:, :2], np.arange(len(strip.vertices)), none, "by hand")
        patch = PinnedPatch(strip, chart)
        assert len(chart.faces) > WHOLE
        assert not patch.by_proxy
        patch.add(at(chart, 0))
        assert np.isfinite(patch.frame()).all()

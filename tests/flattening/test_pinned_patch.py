"""A patch follows its pins without a flip, and converges to a map that is one-to-one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.flattening.chart import Chart, Pin
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.flattening.methods import METHODS
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.pinned_patch import WHOLE, PinFollower, PinnedPatch, _laid_over
from tactile_maps.flattening.reduced_model import build_coarse_cage
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tests.flattening.pinned_patches import at, dome, far_points, pinned, waves
from tests.support.surfaces import sheet


@pytest.fixture(params=["whole", "by a coarse cage"])
def follower(request):
    surface, chart = waves()
    unit = np.sqrt(surface.area)
    plane = chart.plane / unit
    disk = Disk(Mesh((surface.vertices - surface.vertices.mean(axis=0))[chart.vertex_of] / unit, chart.faces))
    cage = build_coarse_cage(surface, replace(chart, plane=plane), faces=700) if request.param != "whole" else None
    return PinFollower(disk.energy, plane, cage=cage), chart, plane


def held(chart, plane):
    corners = chart.faces[[int(np.flatnonzero((chart.faces == v).any(axis=1))[0]) for v in far_points(plane, 4)]]
    weights = np.tile([0.2, 0.3, 0.5], (4, 1))
    return corners, weights, np.einsum("pc,pcd->pd", weights, plane[corners])


def test_patch_without_pins_does_not_move(follower):
    moving, _, plane = follower
    assert moving.still
    np.testing.assert_allclose(moving.plane, plane, atol=1e-12)


def test_patch_follows_its_pins_and_comes_to_rest(follower):
    moving, chart, plane = follower
    corners, weights, places = held(chart, plane)
    moving.pin(corners, weights, places)
    assert not moving.still
    moving.aim(places + [[0.1, 0.05], [0, 0], [0, 0], [0, 0]])
    before = moving.energy
    for _ in range(60):
        moving.frame()
        assert moving.energy <= before
        assert not flipped(moving.plane, chart.faces).any()
        before = moving.energy
        if moving.still:
            break
    assert moving.still
    there = np.einsum("pc,pcd->pd", weights, moving.plane[corners])
    np.testing.assert_allclose(there, places + [[0.1, 0.05], [0, 0], [0, 0], [0, 0]], atol=2e-3)


def test_whole_and_reduced_model_give_the_same_map():
    surface, chart = waves()
    unit = np.sqrt(surface.area)
    plane = chart.plane / unit
    disk = Disk(Mesh((surface.vertices - surface.vertices.mean(axis=0))[chart.vertex_of] / unit, chart.faces))
    both = [
        PinFollower(disk.energy, plane),
        PinFollower(disk.energy, plane, cage=build_coarse_cage(surface, replace(chart, plane=plane), faces=700)),
    ]
    corners, weights, places = held(chart, plane)
    for moving in both:
        moving.pin(corners, weights, places + [[0.1, 0.05], [0, 0], [0, 0], [0, 0]])
        for _ in range(20):
            moving.frame()
    assert both[0].energy > disk.energy.energy(plane) + 0.02, "the pull costs something"
    assert both[0].energy <= both[1].energy < both[0].energy + 0.05
    assert np.abs(both[0].plane - both[1].plane).max() < 0.02


def test_small_patch_reaches_moved_pins_within_one_frame(follower):
    moving, chart, plane = follower
    corners, weights, places = held(chart, plane)
    moving.pin(corners, weights, places)
    moving.aim(places + 0.08)
    moving.frame()
    gone = np.einsum("pc,pcd->pd", weights, moving.plane[corners]) - places
    assert (gone > 0.05).all()


class Cancelled(Exception):
    """Raised by a progress callback to stop."""


def test_map_is_at_its_pins_and_one_to_one():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + [0.012, 0.006])
    settled = patch.converge()
    assert not flipped(settled.plane, settled.faces).any()
    assert crossings(settled.plane[settled.border]) == 0
    chosen = far_points(chart.plane, 5)
    np.testing.assert_allclose(settled.plane[chosen[1:]], places[1:], atol=1e-4)
    np.testing.assert_allclose(settled.plane[chosen[0]], places[0] + [0.012, 0.006], atol=1e-4)
    assert settled.method == chart.method
    assert len(settled.energies) == len(settled.seconds) > 1
    np.testing.assert_array_equal(settled.faces, chart.faces)


def test_progress_is_reported_and_may_cancel_without_effect():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + 0.01)
    before = patch.plane
    reported = []

    def stop(iterate):
        reported.append(iterate.energy)
        if len(reported) == 3:
            raise Cancelled

    with pytest.raises(Cancelled):
        patch.converge(on_round=stop)
    np.testing.assert_array_equal(patch.plane, before)
    assert len(reported) == 3
    assert patch.converge(on_round=lambda _: None).energies[-1] < 5


def test_descent_ended_early_has_a_finding_until_it_converges(monkeypatch):
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + [0.012, 0.006])
    with monkeypatch.context() as hurried:
        hurried.setitem(minimise.__kwdefaults__, "rounds", 1)
        early = patch.converge()
    assert "descent-stopped" in [note.kind for note in early.findings]
    assert not flipped(early.plane, early.faces).any()
    again, numbers, _places = pinned(surface, early)
    again.move(numbers[0], places[0] + [0.012, 0.006])
    assert "descent-stopped" not in [note.kind for note in again.converge().findings]


@pytest.mark.long
def test_overlap_of_the_border_is_avoided():
    strip = sheet(60, 3, width=0.6, height=0.03)
    patch = PinnedPatch(strip, _flat(strip))
    left, right, middle = (
        int(np.argmin(np.linalg.norm(strip.vertices[:, :2] - p, axis=1))) for p in ((0, 0.01), (0.6, 0.01), (0.3, 0.01))
    )
    ends = [patch.add(at(_flat(strip), v)) for v in (left, right, middle)]
    # Bent into a ring and on, so that one end crosses the other.
    for turn in np.linspace(0, 2.15 * np.pi, 60)[1:]:
        radius = 0.6 / turn
        patch.move(ends[0], (0.3 - radius * np.sin(turn / 2), 0.01 + radius * (1 - np.cos(turn / 2))))
        patch.move(ends[1], (0.3 + radius * np.sin(turn / 2), 0.01 + radius * (1 - np.cos(turn / 2))))
        patch.frame()
    for _ in range(30):
        patch.frame()
    chart = _flat(strip)
    assert crossings(patch.plane[chart.border]) > 0, "the hand has crossed the ends"
    settled = patch.converge()
    assert crossings(settled.plane[chart.border]) == 0
    assert not flipped(settled.plane, settled.faces).any()
    assert "overlap-avoided" in [note.kind for note in settled.findings]


@pytest.mark.parametrize("angle", [-2.5, 0.3, 1.9])
def test_start_without_overlap_is_rotated_and_moved_onto_the_dragged_map(angle):
    plane = np.random.default_rng(0).random((20, 2))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    dragged = plane @ turn + [3.0, -1.0]
    np.testing.assert_allclose(_laid_over(plane, dragged), dragged, atol=1e-12)


def test_pins_behind_their_targets_are_reported_once():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart, 3)
    patch.move(numbers[0], places[1])
    settled = patch.converge()
    again = patch.converge()
    assert not flipped(settled.plane, settled.faces).any()
    for chart_ in (settled, again):
        assert [note.kind for note in chart_.findings].count("pin-behind") == 1
    assert "mm from its target" in settled.findings[-1].action


def test_settled_map_does_not_move():
    surface, chart = waves()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + 0.005)
    first = patch.converge()
    again = patch.converge()
    assert np.abs(again.plane - first.plane).max() < 1e-4 * np.sqrt(surface.area)


def test_settled_map_depends_on_the_weight_of_lengths():
    surface, chart = dome()
    ends = {}
    for lengths in (0.0, 1.0):
        patch, numbers, places = pinned(surface, chart, lengths=lengths)
        patch.move(numbers[0], places[0] + 0.01)
        ends[lengths] = patch.converge().plane
    assert np.abs(ends[0.0] - ends[1.0]).max() > 1e-3


@pytest.mark.long
def test_impossible_pin_places_give_an_error_or_a_valid_map():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart, 4)
    patch.move(numbers[0], places[0] + 3.0)
    patch.move(numbers[1], places[2])
    patch.move(numbers[2], places[1])
    try:
        settled = patch.converge()
    except MapError:
        assert not flipped(patch.plane, chart.faces).any(), "refused, the hand's map stays"
        return
    assert not flipped(settled.plane, settled.faces).any()
    assert crossings(settled.plane[settled.border]) == 0


def _flat(surface):
    none = np.zeros((0, 2), dtype=np.int64)
    return Chart(surface.faces, surface.vertices[:, :2], np.arange(len(surface.vertices)), none, "by hand")


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


def test_adding_a_pin_does_not_change_the_map():
    surface, chart = waves()
    patch, numbers, places = pinned(surface, chart)
    assert list(patch.pins) == numbers == [0, 1, 2, 3, 4]
    assert patch.lag < 1e-9
    np.testing.assert_allclose([pin.place for pin in patch.pins.values()], places, atol=1e-12)
    assert np.abs(patch.frame() - chart.plane).max() < 0.01 * np.sqrt(surface.area)


def test_dragged_pin_is_followed_within_a_frame():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    end = places[0] + [0.01, 0.0]
    dragged(patch, numbers[0], line(places[0], end))
    assert patch.lag < 1e-3 * np.sqrt(surface.area)
    np.testing.assert_allclose(patch.plane[far_points(chart.plane, 1)[0]], end, atol=1e-4)
    for _ in range(10):
        patch.frame()
    assert patch.still


@pytest.mark.long
def test_energy_is_within_one_percent_of_the_minimum_after_a_few_frames_at_rest():
    for surface, chart in (dome(), waves()):
        patch, numbers, places = pinned(surface, chart)
        size = np.ptp(chart.plane, axis=0).min()
        dragged(patch, numbers[0], line(places[0], places[0] + [0.15 * size, 0.1 * size]))
        for _ in range(5):
            patch.frame()
        *_, least = minimise(patch._pinned(), patch._follower.plane, tolerance=1e-9)
        assert least.energy <= patch.energy <= 1.01 * least.energy


@pytest.mark.long
def test_energy_returns_to_its_start_when_the_pin_moves_back():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    for _ in range(20):
        patch.frame()
    before = patch.energy
    plane = patch.plane
    dragged(patch, numbers[0], line(places[0], places[0] + [0.01, 0.01]))
    assert patch.energy > before + 0.01
    dragged(patch, numbers[0], line(places[0] + [0.01, 0.01], places[0]))
    for _ in range(20):
        patch.frame()
    assert patch.energy == pytest.approx(before, rel=1e-6)
    assert np.abs(patch.plane - plane).max() < 1e-3 * np.sqrt(surface.area)


def test_single_pin_moves_the_whole_map():
    surface, chart = dome()
    patch, (number,), places = pinned(surface, chart, 1)
    dragged(patch, number, line(places[0], places[0] + 0.05))
    for _ in range(20):
        patch.frame()
    assert patch.energy < 4.16
    np.testing.assert_allclose(patch.plane.mean(axis=0), chart.plane.mean(axis=0) + 0.05, atol=0.01)


def test_energy_is_minimised_without_pins():
    surface, chart = dome()
    patch = PinnedPatch(surface, chart)
    assert patch.lag == 0.0
    patch.frame()
    assert patch.energy < 4.16


@pytest.mark.parametrize("method", METHODS)
def test_map_of_any_method_can_be_dragged(method):
    surface, _ = dome()
    chart = flatten(surface, method=method)
    patch, numbers, places = pinned(surface, chart)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.008))
    for _ in range(10):
        patch.frame()
    assert patch.lag < 1e-3


@pytest.mark.parametrize("lengths", [0.0, 0.5, 1.0])
def test_patch_follows_at_any_weight_of_lengths(lengths):
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart, lengths=lengths)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.01))
    assert patch.lag < 1e-3 * np.sqrt(surface.area)


class TestContradictoryPins:
    """The map stays finite, no triangle flips, and the lag is reported."""

    def test_swapping_two_pins_keeps_the_map_valid(self):
        surface, chart = dome()
        patch, (first, second, *_), places = pinned(surface, chart)
        for here, there in zip(line(places[0], places[1]), line(places[1], places[0]), strict=True):
            patch.move(second, there)
            dragged(patch, first, [here])

    @pytest.mark.parametrize("far", [0.2, 1.0, 5.0])
    def test_pin_dragged_out_of_reach_is_reported(self, far):
        surface, chart = dome()
        patch, numbers, places = pinned(surface, chart)
        dragged(patch, numbers[0], [places[0] + [far, 0.0]] * 30)
        assert patch.lag > 0, "an unreachable place is reported"

    @pytest.mark.long
    def test_pin_dragged_onto_another_keeps_the_map_valid(self):
        surface, chart = dome()
        patch, numbers, places = pinned(surface, chart)
        dragged(patch, numbers[0], [*line(places[0], places[1]), *[places[1]] * 20])

    def test_pin_that_jumps_across_the_patch_and_back_is_reached(self):
        surface, chart = waves()
        patch, numbers, places = pinned(surface, chart)
        dragged(patch, numbers[0], [places[1] + 0.01, places[2], places[3] - 0.02, *[places[0]] * 30])
        assert patch.lag < 1e-3 * np.sqrt(surface.area)


class TestRejectedInput:
    """Invalid input raises a named error and leaves the patch unchanged."""

    @pytest.mark.parametrize("place", [(np.nan, 0.0), (0.0, np.inf), (1e3, 0.0), (-1e300, 1.0)])
    def test_invalid_pin_place_is_rejected(self, place):
        surface, chart = dome()
        patch, numbers, places = pinned(surface, chart)
        with pytest.raises(MapError, match="too far from the map"):
            patch.move(numbers[0], place)
        with pytest.raises(MapError, match="too far from the map"):
            patch.add(SurfacePoint(0, 7, (0.4, 0.3, 0.3)), place)
        assert list(patch.pins) == numbers
        np.testing.assert_allclose([pin.place for pin in patch.pins.values()], places, atol=1e-12)

    @pytest.mark.parametrize(
        ("face", "weights"),
        [(-1, (1, 0, 0)), (10**6, (1, 0, 0)), (0, (2, -1, 0)), (0, (0.2, 0.2, 0.2)), (0, (np.nan, 0.5, 0.5))],
    )
    def test_pin_off_the_patch_is_rejected(self, face, weights):
        with pytest.raises(MapError, match="not on the patch"):
            PinnedPatch(*dome()).add(SurfacePoint(0, face, weights))

    def test_second_pin_at_the_same_place_is_rejected(self):
        surface, chart = dome()
        patch, _, _ = pinned(surface, chart)
        vertex = far_points(chart.plane, 1)[0]
        for face in np.flatnonzero((chart.faces == vertex).any(axis=1)):
            with pytest.raises(MapError, match="pin is already"):
                patch.add(SurfacePoint(0, int(face), tuple((chart.faces[face] == vertex).astype(float))))

    def test_unknown_pin_is_rejected(self):
        patch = PinnedPatch(*dome())
        with pytest.raises(MapError, match="unknown pin"):
            patch.move(0, (0.0, 0.0))

    def test_share_of_lengths_above_one_is_rejected(self):
        with pytest.raises(MapError, match="share of lengths is out of range"):
            PinnedPatch(*dome(), lengths=1.5)

    def test_chart_of_another_surface_is_rejected(self):
        with pytest.raises(MapError, match="another surface"):
            PinnedPatch(dome()[0], waves()[1])

    def test_map_with_flips_is_rejected(self):
        surface, chart = dome()
        with pytest.raises(MapError, match="flipped"):
            PinnedPatch(surface, replace(chart, plane=chart.plane * [-1, 1]))


def test_earlier_pins_and_plane_can_be_restored():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    dragged(patch, numbers[0], line(places[0], places[0] + 0.01))
    again = PinnedPatch(surface, replace(chart, plane=patch.plane), pins=tuple(patch.pins.values()))
    assert again.energy == pytest.approx(patch.energy, rel=1e-9)
    assert list(again.pins.values()) == list(patch.pins.values())
    assert all(isinstance(pin, Pin) for pin in again.pins.values())


class TestLargePatches:
    """Followed by a coarse cage, settled in full."""

    def test_large_patches_follow_and_converge_like_small_ones(self):
        surface, chart = waves()
        small, numbers, places = pinned(surface, chart)
        large, _, _ = pinned(surface, chart, whole=1000)
        assert large._follower.cage is not None
        assert small._follower.cage is None
        for patch in (small, large):
            dragged(patch, numbers[0], line(places[0], places[0] + 0.015))
        assert large.lag < 2e-3 * np.sqrt(surface.area)
        exact = small.converge()
        refined = large.converge()
        np.testing.assert_allclose(refined.plane, exact.plane, atol=2e-3 * np.sqrt(surface.area))
        assert large._follower.cage is not None
        assert large.lag < 1e-3 * np.sqrt(surface.area)

    def test_patch_without_valid_cage_moves_all_faces(self):
        strip = sheet(7000, 1, width=1.0, height=0.0001)
        none = np.zeros((0, 2), dtype=np.int64)
        chart = Chart(strip.faces, strip.vertices[:, :2], np.arange(len(strip.vertices)), none, "by hand")
        patch = PinnedPatch(strip, chart)
        assert len(chart.faces) > WHOLE
        assert patch._follower.cage is None
        patch.add(at(chart, 0))
        assert np.isfinite(patch.frame()).all()

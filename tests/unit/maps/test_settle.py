"""A pinned map at rest: converged, one-to-one, and told where pins could not get."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.maps.bijective import crossings, flipped
from app.maps.chart import Chart
from app.maps.pins import PinnedPatch
from tests.numerics.map_surfaces import sheet
from tests.unit.maps.pinned_patches import at, dome, far_points, pinned, waves


class Cancelled(Exception):
    """What a progress callback raises to stop."""


def test_the_map_is_where_its_pins_are_and_one_to_one():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + [0.012, 0.006])
    settled = patch.settle()
    assert not flipped(settled.plane, settled.faces).any()
    assert crossings(settled.plane[settled.border]) == 0
    chosen = far_points(chart.plane, 5)
    np.testing.assert_allclose(settled.plane[chosen[1:]], places[1:], atol=1e-4)
    np.testing.assert_allclose(settled.plane[chosen[0]], places[0] + [0.012, 0.006], atol=1e-4)
    assert settled.method == chart.method
    assert len(settled.energies) == len(settled.seconds) > 1
    np.testing.assert_array_equal(settled.faces, chart.faces)


def test_progress_is_told_and_may_cancel_with_all_as_it_was():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + 0.01)
    before, told = patch.plane, []

    def stop(iterate):
        told.append(iterate.energy)
        if len(told) == 3:
            raise Cancelled

    with pytest.raises(Cancelled):
        patch.settle(progress=stop)
    np.testing.assert_array_equal(patch.plane, before)
    assert len(told) == 3
    assert patch.settle(progress=lambda _: None).energies[-1] < 5


def test_a_border_that_would_lie_on_itself_is_kept_apart():
    strip = sheet(60, 3, width=0.6, height=0.03)
    patch = PinnedPatch(strip, _flat(strip))
    left, right, middle = (
        int(np.argmin(np.linalg.norm(strip.vertices[:, :2] - p, axis=1))) for p in ((0, 0.01), (0.6, 0.01), (0.3, 0.01))
    )
    ends = [patch.add(at(_flat(strip), v)) for v in (left, right, middle)]
    # Bent into a ring and on, so that one end lies across the other.
    for turn in np.linspace(0, 2.15 * np.pi, 60)[1:]:
        radius = 0.6 / turn
        patch.move(ends[0], (0.3 - radius * np.sin(turn / 2), 0.01 + radius * (1 - np.cos(turn / 2))))
        patch.move(ends[1], (0.3 + radius * np.sin(turn / 2), 0.01 + radius * (1 - np.cos(turn / 2))))
        patch.frame()
    for _ in range(30):
        patch.frame()
    chart = _flat(strip)
    assert crossings(patch.plane[chart.border]) > 0, "the hand has crossed the ends"
    settled = patch.settle()
    assert crossings(settled.plane[chart.border]) == 0
    assert not flipped(settled.plane, settled.faces).any()
    assert "overlap-avoided" in [note.kind for note in settled.findings]


def test_pins_that_cannot_get_where_they_are_wanted_are_told_once():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart, 3)
    patch.move(numbers[0], places[1])
    settled = patch.settle()
    again = patch.settle()
    assert not flipped(settled.plane, settled.faces).any()
    for chart_ in (settled, again):
        assert [note.kind for note in chart_.findings].count("pin-behind") == 1
    assert "mm from where it is wanted" in settled.findings[-1].action


def test_a_settled_map_at_rest_stays():
    surface, chart = waves()
    patch, numbers, places = pinned(surface, chart)
    patch.move(numbers[0], places[0] + 0.005)
    first = patch.settle()
    again = patch.settle()
    assert np.abs(again.plane - first.plane).max() < 1e-4 * np.sqrt(surface.area)


def test_lengths_and_angles_have_their_own_rest():
    surface, chart = dome()
    ends = {}
    for lengths in (0.0, 1.0):
        patch, numbers, places = pinned(surface, chart, lengths=lengths)
        patch.move(numbers[0], places[0] + 0.01)
        ends[lengths] = patch.settle().plane
    assert np.abs(ends[0.0] - ends[1.0]).max() > 1e-3


def test_a_hopeless_wish_is_an_error_or_a_valid_map():
    surface, chart = dome()
    patch, numbers, places = pinned(surface, chart, 4)
    patch.move(numbers[0], places[0] + 3.0)
    patch.move(numbers[1], places[2])
    patch.move(numbers[2], places[1])
    try:
        settled = patch.settle()
    except MapError:
        assert not flipped(patch.plane, chart.faces).any(), "refused, the hand's map stays"
        return
    assert not flipped(settled.plane, settled.faces).any()
    assert crossings(settled.plane[settled.border]) == 0


def _flat(surface):
    none = np.zeros((0, 2), dtype=np.int64)
    return Chart(surface.faces, surface.vertices[:, :2], np.arange(len(surface.vertices)), none, "by hand")

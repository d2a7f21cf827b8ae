"""Random hands on random pins: no flip, nothing infinite, never uphill, whatever the order and frame of reference."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.errors import MapError
from app.geometry.mesh import Mesh
from app.geometry.surface_point import SurfacePoint
from app.maps.bijective import crossings, flipped
from app.maps.chart import Chart
from app.maps.flatten import flatten
from app.maps.pins import PinnedPatch
from tests.numerics.map_surfaces import cap, frustum, sheet

SURFACES = (
    cap(1.2, rings=8, radius=0.05),
    frustum(around=24, along=12),
    sheet(20, 14, shape=lambda x, y: 0.01 * np.sin(70 * x) * np.cos(60 * y)),
)
CHARTS = tuple(flatten(surface) for surface in SURFACES)

shares = st.floats(0, 1)
weights = st.tuples(shares, shares, shares).filter(lambda w: sum(w) > 0.1)
places = st.tuples(st.floats(-1, 2), st.floats(-1, 2))
acts = st.one_of(
    st.tuples(st.just("add"), st.integers(0, 10**6), weights, places),
    st.tuples(st.just("move"), st.integers(0, 20), places),
    st.tuples(st.just("remove"), st.integers(0, 20)),
    st.tuples(st.just("wait"), st.integers(1, 4)),
)


def on_map(chart, share):
    """A place by shares of the map's box; outside from 0 to 1 is outside the map."""
    low, high = chart.plane.min(axis=0), chart.plane.max(axis=0)
    return low + (high - low) * share


def act(patch, chart, what, *how):
    """One thing a hand may do, with whatever it is refused by name."""
    numbers = list(patch.pins)
    try:
        if what == "add":
            face, corner_weights, place = how
            unit = np.array(corner_weights) / sum(corner_weights)
            patch.add(SurfacePoint(0, face % len(chart.faces), tuple(unit.tolist())), on_map(chart, place))
        elif what == "move" and numbers:
            patch.move(numbers[how[0] % len(numbers)], on_map(chart, how[1]))
        elif what == "remove" and numbers:
            patch.remove(numbers[how[0] % len(numbers)])
    except MapError as refused:
        return str(refused)
    return ""


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.integers(0, len(SURFACES) - 1), st.booleans(), st.sampled_from([0.0, 0.6, 1.0]), st.lists(acts, max_size=14))
def test_no_hand_makes_a_flip(which, by_proxy, lengths, done):
    surface, chart = SURFACES[which], CHARTS[which]
    patch = PinnedPatch(surface, chart, lengths=lengths, whole=100 if by_proxy else 10**6)
    for what, *how in done:
        act(patch, chart, what, *how)
        for frame in range(how[0] if what == "wait" else 1):
            before = patch.energy
            plane = patch.frame()
            assert np.isfinite(plane).all()
            assert not flipped(plane, chart.faces).any()
            assert patch.energy <= before, frame
            assert np.isfinite(patch.lags).all()


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.integers(0, len(SURFACES) - 1), st.lists(acts, min_size=2, max_size=8))
def test_any_hand_leaves_a_map_that_settles_one_to_one_or_stays(which, done):
    surface, chart = SURFACES[which], CHARTS[which]
    patch = PinnedPatch(surface, chart)
    for what, *how in done:
        act(patch, chart, what, *how)
        patch.frame()
    before = patch.plane
    try:
        settled = patch.settle()
    except MapError:
        np.testing.assert_array_equal(patch.plane, before)
        return
    assert not flipped(settled.plane, settled.faces).any()
    assert crossings(settled.plane[settled.border]) == 0


def pulled(surface, chart, faces, moves):
    """The settled map after pins in ``faces`` made ``moves``."""
    patch = PinnedPatch(surface, chart)
    for face, move in zip(faces, moves, strict=True):
        number = patch.add(SurfacePoint(0, int(face), (0.2, 0.3, 0.5)))
        patch.move(number, np.array(patch.pins[number].place) + move)
    for _ in range(3):
        patch.frame()
    return patch, patch.settle()


@pytest.mark.parametrize("which", range(len(SURFACES)))
def test_the_order_of_faces_and_pins_does_not_matter(which):
    surface, chart = SURFACES[which], CHARTS[which]
    faces, moves = np.array([3, 50, 150]), np.array([[0.008, 0.0], [0.0, 0.0], [0.0, 0.004]])
    _, straight = pulled(surface, chart, faces, moves)
    order = np.random.default_rng(which).permutation(len(surface.faces))
    mixed = Mesh(surface.vertices, surface.faces[order])
    other = Chart(chart.faces[order], chart.plane, chart.vertex_of, chart.seams, chart.method)
    _, shuffled = pulled(mixed, other, np.argsort(order)[faces[::-1]], moves[::-1])
    np.testing.assert_allclose(shuffled.plane, straight.plane, atol=2e-3 * np.sqrt(surface.area))
    assert shuffled.energies[-1] == pytest.approx(straight.energies[-1], rel=1e-4)


@pytest.mark.parametrize("which", range(len(SURFACES)))
@settings(max_examples=5, deadline=None, derandomize=True)
@given(turn=st.floats(-3, 3), shift=st.tuples(st.floats(-2, 2), st.floats(-2, 2)), size=st.sampled_from([0.01, 1, 100]))
def test_turned_moved_and_enlarged_it_is_the_same(which, turn, shift, size):
    surface, chart = SURFACES[which], CHARTS[which]
    faces, moves = np.array([3, 50, 150]), np.array([[0.008, 0.0], [0.0, 0.0], [0.0, 0.004]])
    straight, settled = pulled(surface, chart, faces, moves)
    rotation = size * np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    larger = Mesh(size * surface.vertices, surface.faces)
    there = Chart(chart.faces, chart.plane @ rotation + shift, chart.vertex_of, chart.seams, chart.method)
    other, moved = pulled(larger, there, faces, moves @ rotation)
    unit = size * np.sqrt(surface.area)
    np.testing.assert_allclose(moved.plane, settled.plane @ rotation + shift, atol=2e-3 * unit)
    assert other.energy == pytest.approx(straight.energy, rel=1e-3)

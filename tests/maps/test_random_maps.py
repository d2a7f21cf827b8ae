"""Random surfaces, layouts and paths drawn on the map: what holds for all of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tactile_maps.control.path_following.surface_path import SurfacePath
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.flattening.cut import cut_to_disk
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.symmetric_dirichlet import rotation_svd
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import map_from_bytes, map_to_bytes
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.seam_transitions import SeamTransitions
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import MapPath
from tests.support.examples import examples
from tests.support.surfaces import blocks, frustum, sheet, skin_of
from tests.support.touch import arm
from tests.support.two_plates import two_plates

MAP = build_map(skin_of(sheet(8, 6), frustum(around=16, along=6), taxels=12))
DATA = map_to_bytes(MAP)

cells = st.sets(st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(0, 1)), min_size=1, max_size=10)
numbers = st.floats(-1e3, 1e3)


def _face_connected(chosen):
    """The part of ``chosen`` that hangs together with its first cell through whole faces, not edges or corners."""
    found = set()
    front = [min(chosen)]
    while front:
        cell = front.pop()
        if cell in chosen and cell not in found:
            found.add(cell)
            front += [tuple(np.add(cell, step)) for step in (*np.eye(3, dtype=int), *-np.eye(3, dtype=int))]
    return found


def _manifold(chosen):
    """No two cells that meet in an edge or a corner only."""
    for cell in chosen:
        for step in np.ndindex(3, 3, 3):
            other = tuple(np.add(cell, step) - 1)
            if other in chosen and np.abs(np.subtract(other, cell)).sum() > 1:
                between = [tuple(np.add(cell, part)) for part in _parts(np.subtract(other, cell))]
                if not any(path in chosen for path in between):
                    return False
    return True


def _parts(step):
    """Steps along one axis of a diagonal step."""
    return [np.where(np.arange(3) == axis, step, 0) for axis in np.flatnonzero(step)]


@pytest.mark.long
@examples(40)
@given(cells)
def test_any_pile_of_blocks_is_flattened(chosen):
    chosen = _face_connected(chosen)
    assume(_manifold(chosen))
    chart = flatten(blocks(chosen))
    assert not flipped(chart.plane, chart.faces).any()
    assert crossings(chart.plane[chart.connectivity.boundary_loops[0]]) == 0


@examples(25)
@given(hnp.arrays(float, (7, 5), elements=st.floats(-0.04, 0.04)))
def test_any_height_field_is_flattened(heights):
    surface = sheet(6, 4, shape=lambda x, y: heights)
    assert len(cut_to_disk(surface).seams) == 0
    chart = flatten(surface)
    assert not flipped(chart.plane, chart.faces).any()
    assert crossings(chart.plane[chart.connectivity.boundary_loops[0]]) == 0
    assert chart.energies[-1] <= chart.energies[0]


@examples(60)
@given(hnp.arrays(float, (5, 2, 2), elements=numbers))
def test_rotation_svd_rebuilds_any_matrix(matrices):
    u, s, vt = rotation_svd(matrices)
    size = 1 + np.abs(matrices).max()
    np.testing.assert_allclose(np.einsum("fij,fj,fjk->fik", u, s, vt), matrices, atol=1e-9 * size)


@pytest.mark.long
@examples(40)
@given(st.floats(-10, 10), st.tuples(st.floats(-5, 5), st.floats(-5, 5)), st.booleans())
def test_every_layout_maps_in_both_directions(angle, offset, mirrored):
    # The second patch is well apart from any position of the first.
    moved = TactileMap(
        MAP.skin, MAP.charts, MapLayout((Placement(angle, offset, mirrored), Placement(0.0, (50.0, 0.0))))
    )
    patch, face, weights = moved.to_body_many(moved.taxel_points)
    np.testing.assert_array_equal(patch, moved.skin.patch_of)
    np.testing.assert_allclose(moved.to_map_many(patch, face, weights), moved.taxel_points, atol=1e-12)
    assert map_to_bytes(map_from_bytes(map_to_bytes(moved))) == map_to_bytes(moved)


@examples(60)
@given(st.integers(0, len(DATA) - 1), st.integers(1, 255))
def test_file_with_any_changed_byte_is_read_completely_or_rejected_by_name(place, change):
    damaged = bytearray(DATA)
    damaged[place] ^= change
    try:
        map_ = map_from_bytes(bytes(damaged))
    except TactileMapsError:
        return
    assert np.isfinite(map_.taxel_points).all()
    assert (map_.to_body_many(map_.taxel_points)[0] >= 0).all()


FLAT = SeamTransitions(two_plates())
ARM = SeamTransitions(arm().map)
POINTS = st.lists(st.tuples(st.floats(-0.05, 0.3), st.floats(-0.05, 0.15)), min_size=1, max_size=8)
GRAZING = [(0.0, 0.0), (0.0, 0.125), (0.125, 0.0), (0.0, -1.2e-07)]
"""The last side is 0 to 0.1 µm away from a border."""
SHARES = st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=1, max_size=5)


def _inside(patch, x, y):
    lower = FLAT.map.uv[patch].min(axis=0)
    upper = FLAT.map.uv[patch].max(axis=0)
    return tuple((lower + (x, y) * (upper - lower)).tolist())


ON_SKIN = st.builds(_inside, st.integers(0, 1), st.floats(0.0, 1.0), st.floats(0.0, 1.0))


def laid_from(transitions, points, *, drawn=True):
    """The path, drawn from the first of its points that is on the skin."""
    path = MapPath(np.array(points))
    assume(transitions.map.to_body(path.points[0]) is not None)
    return path, SurfacePath(path, transitions, drawn=drawn)


def _length_in_plates(points, grown):
    """Return the length of each side of a polygon inside either plate, each ``grown`` on all sides [m].

    Each side is clipped by one border line after the other (Liang and Barsky 1984).
    """
    lengths = []
    for start, end in pairwise(points):
        side = end - start
        for left in (0.0, 0.12):
            low = np.array([left, 0.0]) - grown
            high = np.array([left + 0.1, 0.1]) + grown
            with np.errstate(divide="ignore", invalid="ignore"):
                ways = np.sort([(low - start) / side, (high - start) / side], axis=0)
            along = side == 0  # never meets this pair of lines: in between or not
            if (along & ((start < low) | (start > high))).any():
                continue
            enters = ways[0, ~along].max(initial=0.0)
            leaves = ways[1, ~along].min(initial=1.0)
            lengths.append(max(leaves - enters, 0.0) * np.linalg.norm(side))
    return lengths


def _lengths_between(path):
    """A side along a border is on or off the skin by rounding; both are correct."""
    return [sum(_length_in_plates(path.points, grown)) for grown in (-1e-6, 1e-6)]


@pytest.mark.long
@examples(200)
@given(POINTS, SHARES)
@example(GRAZING, [0.0])
def test_path_on_skin_without_seams_is_the_part_inside(points, shares):
    path, laid = laid_from(FLAT, points)
    shortest, longest = _lengths_between(path)
    assert shortest - 1e-5 <= laid.length <= longest + 1e-5
    for share in shares:
        way = share * laid.length
        at, direction = laid.at(way)
        point = FLAT.map.to_map(at)
        step = path.points[1:] - path.points[:-1]
        if not len(step):
            continue
        along = np.clip(np.einsum("ki,ki->k", point - path.points[:-1], step) / np.sum(step**2, axis=1), 0, 1)
        off = np.linalg.norm(path.points[:-1] + along[:, None] * step - point, axis=1).min()
        assert off < 1e-6, "it is where it was drawn"
        assert np.linalg.norm(direction) == pytest.approx(1.0 if laid.length else 0.0)
        again = FLAT.map.to_body(point)
        assert np.linalg.norm(FLAT.map.skin.position(again) - FLAT.map.skin.position(at)) < 1e-6


@pytest.mark.long
@examples(100)
@given(st.integers(0, 299), st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)), max_size=6), st.booleans())
def test_path_on_the_arm_jumps_only_at_crossings(taxel, steps, drawn):
    map_ = arm().map
    start = map_.taxel_points[taxel]
    _, laid = laid_from(ARM, [start, *(start + np.cumsum(np.array(steps).reshape(-1, 2), axis=0))], drawn=drawn)
    assert drawn or not laid.crossings
    ways = np.linspace(0, laid.length * (1 - 1e-9), 400)
    pieces = np.array([laid.piece(way) for way in ways])
    places = [laid.at(way)[0] for way in ways]
    body = np.array([map_.skin.position(at) for at in places])
    jumps = np.linalg.norm(np.diff(body, axis=0), axis=1)
    reach = 3 * (ways[1] - ways[0]) + 1.6 * np.sqrt(map_.skin.areas.mean())  # short ways over a border are no crossing
    same = pieces[1:] == pieces[:-1]
    assert (jumps[same] < reach).all()
    patches = np.array([at.patch for at in places])
    assert (patches[1:] == patches[:-1])[same].all()
    assert laid.piece(laid.length) == len(laid.crossings)


@pytest.mark.long
@examples(100)
@given(ON_SKIN, POINTS, ON_SKIN, SHARES)
@example((0.125, 0.0), [(0.0, -0.03125)], (0.0, 0.0), [0.0])
def test_path_and_its_reverse_agree(start, between, end, shares):
    path, laid = laid_from(FLAT, [start, *between, end])
    assume(FLAT.map.to_body(path.points[-1]) is not None)
    back = SurfacePath(MapPath(path.points[::-1]), FLAT)
    shortest, longest = _lengths_between(path)
    if longest - shortest > 1e-4:
        return  # with a side along a border one way may leave the skin there and the other not
    unsure = 1e-5 + longest - shortest
    assert back.length == pytest.approx(laid.length, abs=unsure)
    assert len(back.crossings) == len(laid.crossings)
    if not laid.length:
        return  # on the skin in single points only, it is where it first is: another one on the way back
    for share in shares:
        there, here = (FLAT.map.skin.position(one.at(way)[0]) for one, way in
                       ((laid, share * laid.length), (back, (1 - share) * laid.length)))  # fmt: skip
        gaps = [abs(share * laid.length - crossing.way) for crossing in laid.crossings]
        assert np.linalg.norm(there - here) < 1e-5 + unsure or min(gaps, default=1.0) < 1e-4 + unsure

"""Random surfaces and layouts: what holds for all of them."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from app.errors import TactileMapsError
from app.geometry.topology import boundary_loops
from app.maps.bijective import crossings, flipped
from app.maps.build import build_map
from app.maps.cut import cut_to_disk
from app.maps.flatten import flatten
from app.maps.layout import MapLayout, Placement
from app.maps.map_file import map_from_bytes, map_to_bytes
from app.maps.symmetric_dirichlet import rotation_svd
from app.maps.tactile_map import TactileMap
from tests.numerics.map_surfaces import blocks, frustum, sheet, skin_of

MAP = build_map(skin_of(sheet(8, 6), frustum(around=16, along=6), taxels=12))
DATA = map_to_bytes(MAP)

cells = st.sets(st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(0, 1)), min_size=1, max_size=10)
numbers = st.floats(-1e3, 1e3)


def _face_connected(chosen):
    """The part of ``chosen`` that hangs together with its first cell through whole faces, not edges or corners."""
    found, front = set(), [min(chosen)]
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


@settings(max_examples=40, deadline=None)
@given(cells)
def test_any_heap_of_blocks_is_laid_flat(chosen):
    chosen = _face_connected(chosen)
    assume(_manifold(chosen))
    chart = flatten(blocks(chosen))
    assert not flipped(chart.plane, chart.faces).any()
    assert crossings(chart.plane[boundary_loops(chart.faces)[0]]) == 0


@settings(max_examples=25, deadline=None)
@given(hnp.arrays(float, (7, 5), elements=st.floats(-0.04, 0.04)))
def test_any_landscape_is_laid_flat(heights):
    surface = sheet(6, 4, shape=lambda x, y: heights)
    assert len(cut_to_disk(surface).seams) == 0
    chart = flatten(surface)
    assert not flipped(chart.plane, chart.faces).any()
    assert crossings(chart.plane[boundary_loops(chart.faces)[0]]) == 0
    assert chart.energies[-1] <= chart.energies[0]


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(float, (5, 2, 2), elements=numbers))
def test_rotation_svd_rebuilds_any_matrix(matrices):
    u, s, vt = rotation_svd(matrices)
    size = 1 + np.abs(matrices).max()
    np.testing.assert_allclose(np.einsum("fij,fj,fjk->fik", u, s, vt), matrices, atol=1e-9 * size)


@settings(max_examples=40, deadline=None)
@given(st.floats(-10, 10), st.tuples(st.floats(-5, 5), st.floats(-5, 5)), st.booleans())
def test_any_layout_can_be_asked_both_ways(angle, offset, mirrored):
    # The second patch stands well apart from wherever the first may be put.
    moved = TactileMap(
        MAP.skin, MAP.charts, MapLayout((Placement(angle, offset, mirrored), Placement(0.0, (50.0, 0.0))))
    )
    patch, face, weights = moved.to_body_many(moved.taxel_points)
    np.testing.assert_array_equal(patch, moved.skin.patch_of)
    np.testing.assert_allclose(moved.to_map_many(patch, face, weights), moved.taxel_points, atol=1e-12)
    assert map_to_bytes(map_from_bytes(map_to_bytes(moved))) == map_to_bytes(moved)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(DATA) - 1), st.integers(1, 255))
def test_a_file_with_any_byte_changed_opens_whole_or_is_refused_by_name(place, change):
    damaged = bytearray(DATA)
    damaged[place] ^= change
    try:
        map_ = map_from_bytes(bytes(damaged))
    except TactileMapsError:
        return
    assert np.isfinite(map_.taxel_points).all()
    assert (map_.to_body_many(map_.taxel_points)[0] >= 0).all()

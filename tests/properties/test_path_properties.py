"""Whatever is drawn on the map lies on the skin, is as long as what was drawn inside, and goes both ways."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from app.control.laid_path import LaidPath
from app.control.map_path import MapPath
from app.control.path_cut import cut_at_borders
from app.maps.glue import Gluing
from tests.touch import arm
from tests.unit.control.plates import two_plates

FLAT, ARM = Gluing(two_plates()), Gluing(arm().map)
POINTS = st.lists(st.tuples(st.floats(-0.05, 0.3), st.floats(-0.05, 0.15)), min_size=1, max_size=8)
SHARES = st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=1, max_size=5)


def laid_from(gluing, points, *, drawn=True):
    """The path, drawn from the first of its points that is on the skin."""
    path = MapPath(np.array(points))
    assume(gluing.map.to_body(path.points[0]) is not None)
    return path, LaidPath(path, gluing, drawn=drawn)


@settings(max_examples=200, deadline=None)
@given(POINTS, SHARES)
def test_on_skin_without_seams_a_drawn_path_is_what_of_the_drawing_is_inside(points, shares):
    path, laid = laid_from(FLAT, points)
    inside = [run for run in cut_at_borders(path.points, FLAT) if run.patch >= 0]
    drawn = sum(np.linalg.norm(np.diff(run.points, axis=0), axis=1).sum() for run in inside)
    assert laid.length == pytest.approx(drawn, abs=1e-5)
    for share in shares:
        way = share * laid.length
        at, direction = laid.at(way)
        point, step = FLAT.map.to_map(at), path.points[1:] - path.points[:-1]
        if not len(step):
            continue
        along = np.clip(np.einsum("ki,ki->k", point - path.points[:-1], step) / np.sum(step**2, axis=1), 0, 1)
        off = np.linalg.norm(path.points[:-1] + along[:, None] * step - point, axis=1).min()
        assert off < 1e-6, "it lies where it was drawn"
        assert np.linalg.norm(direction) == pytest.approx(1.0 if laid.length else 0.0)
        again = FLAT.map.to_body(point)
        assert np.linalg.norm(FLAT.map.skin.position(again) - FLAT.map.skin.position(at)) < 1e-6


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 299), st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)), max_size=6), st.booleans())
def test_on_the_arm_it_jumps_on_the_body_at_crossings_alone(taxel, steps, drawn):
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
    assert sum(len(line.points) > 0 for line in laid.points_on_body) == len(laid.crossings) + 1


@settings(max_examples=100, deadline=None)
@given(POINTS, SHARES)
def test_there_and_back_is_the_same_way(points, shares):
    path, laid = laid_from(FLAT, points)
    assume(FLAT.map.to_body(path.points[-1]) is not None)
    back = LaidPath(MapPath(path.points[::-1]), FLAT)
    assert back.length == pytest.approx(laid.length, abs=1e-5)
    assert len(back.crossings) == len(laid.crossings)
    for share in shares:
        there, here = (FLAT.map.skin.position(one.at(way)[0]) for one, way in
                       ((laid, share * laid.length), (back, (1 - share) * laid.length)))  # fmt: skip
        gaps = [abs(share * laid.length - crossing.way) for crossing in laid.crossings]
        assert np.linalg.norm(there - here) < 2e-5 or min(gaps, default=1.0) < 1e-4

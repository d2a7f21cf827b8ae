"""Pieces of a path, each within one patch, and where it crosses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.control.path_walk import NEAR, PathWalk, inside
from app.errors import MapError
from app.maps.glue import Gluing
from tests.touch import arm
from tests.unit.control.plates import two_plates

MAP = two_plates()
GLUING = Gluing(MAP)


def walked(*points, drawn=True, gluing=GLUING) -> PathWalk:
    points = np.array(points, dtype=float)
    return PathWalk(gluing, gluing.map.to_body(points[0]), points, drawn=drawn)


def ends(walk):
    return np.array([piece.points for piece in walk.pieces]).reshape(-1, 4)


def test_inside_a_patch_its_pieces_are_the_sides_that_were_drawn():
    walk = walked((0.01, 0.01), (0.05, 0.09), (0.09, 0.01))
    assert ends(walk) == pytest.approx(np.array([[0.01, 0.01, 0.05, 0.09], [0.05, 0.09, 0.09, 0.01]]))
    assert walk.whole
    assert walk.jumps == []
    for piece in walk.pieces:
        assert MAP.to_map(piece.start) == pytest.approx(piece.points[0], abs=1e-6)
        assert MAP.to_map(piece.end) == pytest.approx(piece.points[1], abs=1e-6)


def test_between_patches_it_jumps_and_at_the_end_of_the_skin_it_stops():
    walk = walked((0.05, 0.05), (0.30, 0.05))
    assert [piece.patch for piece in walk.pieces] == [0, 1]
    assert walk.jumps == [1]
    assert not walk.whole
    kept = walked((0.05, 0.05), (0.30, 0.05), drawn=False)
    assert [piece.patch for piece in kept.pieces] == [0]
    assert kept.jumps == []


def test_from_the_border_outwards_it_begins_where_it_comes_in():
    walk = walked((0.10, 0.05), (0.13, 0.05))
    assert [piece.patch for piece in walk.pieces] == [1]
    assert walk.jumps == []


@pytest.mark.parametrize("drawn", [True, False])
@pytest.mark.parametrize("taxel", [10, 60, 150, 250])
def test_on_the_body_each_piece_goes_on_where_the_one_before_ended_but_at_jumps(taxel, drawn):
    map_ = arm().map
    turn = np.linspace(0, 2 * np.pi, 60)
    ring = map_.taxel_points[taxel] + 0.12 * np.stack([np.sin(turn), np.cos(turn) - 1], axis=1)
    walk, skin = walked(*ring, drawn=drawn, gluing=Gluing(map_)), map_.skin
    assert len(walk.pieces) > 3
    for number, (before, after) in enumerate(pairwise(walk.pieces), start=1):
        away = np.linalg.norm(skin.position(before.end) - skin.position(after.start))
        if number in walk.jumps:
            assert before.end.patch != after.start.patch or away > 1e-6
        else:
            assert before.end.patch == after.start.patch
            assert away < NEAR * np.sqrt(skin.areas.mean()) + 1e-6


def test_a_point_on_the_border_is_found_inside_and_nothing_is_not():
    at = inside(MAP, 0, np.array([0.05, 0.05]), np.array([0.1 + 1e-11, 0.05]))
    assert at.patch == 0
    with pytest.raises(MapError, match="no skin at this point"):
        inside(MAP, 1, np.array([0.05, 0.05]), np.array([0.06, 0.05]))

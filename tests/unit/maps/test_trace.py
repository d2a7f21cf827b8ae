"""A straight path on the map is a straight path on the body, also over seams."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.build import build_map
from app.maps.glue import Gluing
from app.maps.layout import MapLayout, Placement
from app.maps.tactile_map import TactileMap
from app.maps.trace import trace
from tests.numerics.map_surfaces import cap, frustum, named, sheet, skin_of
from tests.numerics.straight_walk import unrolled, walk

TUBES = {
    "tube": lambda: frustum(0.03, 0.03, length=0.3, around=30, along=12),
    "cone": lambda: frustum(0.05, 0.02, length=0.2, around=30, along=12),
}


def _start(map_, seed):
    generator = np.random.default_rng(seed)
    face = int(generator.integers(len(map_.charts[0].faces)))
    return SurfacePoint(0, face, tuple(generator.dirichlet([2, 2, 2]).tolist()))


def _direction_on_body(map_, at, step):
    """What a small step on the map is on the body, by the face's own corners."""
    corners = map_.skin.patches[0].surface.vertices[map_.skin.patches[0].surface.faces[at.face]]
    flat = map_.uv[0][map_.charts[0].faces[at.face]]
    share = np.linalg.solve((flat[1:] - flat[0]).T, step)
    return share @ (corners[1:] - corners[0])


@pytest.mark.parametrize("name", sorted(TUBES))
@pytest.mark.parametrize("mirrored", [False, True])
def test_it_ends_where_one_ends_who_walks_straight_on(name, mirrored):
    surface = TUBES[name]()
    map_ = unrolled(surface, angle=1.1, mirrored=mirrored)
    gluing, crossed, stopped = Gluing(map_), 0, 0
    for seed in range(30):
        at, turn = _start(map_, seed), 0.21 * seed
        step = 0.25 * np.array([np.cos(turn), np.sin(turn)])
        end, _, left = walk(surface, at.face, map_.skin.position(at), _direction_on_body(map_, at, step), 0.25)
        path = trace(gluing, at, map_.to_map(at) + step)
        np.testing.assert_allclose(map_.skin.position(path.pieces[-1].end), end, atol=1e-9)
        assert np.linalg.norm(path.remaining) == pytest.approx(left, abs=1e-9)
        assert path.arrived == (left == 0)
        crossed, stopped = crossed + len(path.pieces) - 1, stopped + (left > 0)
    assert crossed > 10
    assert 0 < stopped < 30


@pytest.mark.parametrize("name", ["hemisphere", "bumpy tube", "sphere"])
def test_pieces_follow_each_other_on_the_body(name):
    map_ = build_map(skin_of(named(name)))
    gluing, crossed = Gluing(map_), 0
    for seed in range(20):
        at = _start(map_, seed)
        pieces = trace(gluing, at, map_.to_map(at) + 0.1 * np.array([np.cos(seed), np.sin(seed)])).pieces
        assert pieces[0].start == at
        for before, after in pairwise(pieces):
            np.testing.assert_allclose(map_.skin.position(after.start), map_.skin.position(before.end), atol=1e-12)
            assert np.linalg.norm(after.points[0] - before.points[1]) > 1e-6, "it went over a seam"
        for piece in pieces:
            for point, place in zip(piece.points, (piece.start, piece.end), strict=True):
                np.testing.assert_allclose(map_.to_map(place), point, atol=1e-9)
        crossed += len(pieces) - 1
    assert name == "hemisphere" or crossed > 3


def test_around_a_tube_and_home_again():
    surface = frustum(0.03, 0.03, length=0.3, around=30, along=12)
    map_ = unrolled(surface, angle=0.3)
    at = _start(map_, 1)
    around = 30 * 2 * 0.03 * np.sin(np.pi / 30)
    along_tube = _on_map(map_, at, np.array([0, 0, 1.0]))
    across = np.array([-along_tube[1], along_tube[0]])
    path = trace(Gluing(map_), at, map_.to_map(at) + 3 * around * across)
    assert len(path.pieces) == 4
    np.testing.assert_allclose(map_.skin.position(path.pieces[-1].end), map_.skin.position(at), atol=1e-9)


def _on_map(map_, at, direction):
    corners = map_.skin.patches[0].surface.vertices[map_.skin.patches[0].surface.faces[at.face]]
    flat = map_.uv[0][map_.charts[0].faces[at.face]]
    share = np.linalg.lstsq((corners[1:] - corners[0]).T, direction, rcond=None)[0]
    step = share @ (flat[1:] - flat[0])
    return step / np.linalg.norm(step)


def test_a_path_of_several_points_turns_by_the_same_angles_beyond_the_seam():
    surface = frustum(0.05, 0.02, length=0.2, around=30, along=12)
    map_ = unrolled(surface)
    gluing, at = Gluing(map_), _start(map_, 4)
    here = map_.to_map(at)
    steps = 0.04 * np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 2 * np.pi, 7)[:-1]])
    crossed = 0
    for shift in np.linspace(0, 0.25, 6):
        start = trace(gluing, at, here + [shift, 0.0]).pieces[-1].end if shift else at
        hexagon = map_.to_map(start) + np.cumsum(steps, axis=0)
        path = trace(gluing, start, hexagon)
        if path.arrived:
            np.testing.assert_allclose(map_.skin.position(path.pieces[-1].end), map_.skin.position(start), atol=1e-9)
            crossed += len(path.pieces) > 6
    assert crossed, "one of the hexagons must lie over the seam"


def test_the_rest_of_the_path_is_kept_where_the_skin_ends():
    map_ = unrolled(sheet())
    at = SurfacePoint(0, 0, (0.3, 0.3, 0.4))
    path = trace(Gluing(map_), at, map_.to_map(at) + [0.0, 5.0])
    (piece,) = path.pieces
    assert not path.arrived
    np.testing.assert_allclose(piece.points[1] + path.remaining, map_.to_map(at) + [0.0, 5.0], atol=1e-12)


def test_no_step_is_no_piece():
    map_ = unrolled(sheet())
    at = SurfacePoint(0, 0, (0.3, 0.3, 0.4))
    path = trace(Gluing(map_), at, map_.to_map(at))
    assert (path.pieces, path.arrived) == ((), True)


def test_a_path_that_is_not_finite_is_refused():
    map_ = unrolled(sheet())
    with pytest.raises(MapError, match="finite"):
        trace(Gluing(map_), SurfacePoint(0, 0, (1.0, 0.0, 0.0)), np.array([np.nan, 0]))


def test_a_path_may_start_on_the_seam():
    surface = frustum(0.03, 0.03, length=0.3, around=30, along=12)
    map_ = unrolled(surface)
    gluing = Gluing(map_)
    segment = int(np.flatnonzero(gluing.borders.partner >= 0)[3])
    weights = np.zeros(3)
    side = int(gluing.borders.side[segment])
    weights[[side, (side + 1) % 3]] = 0.4, 0.6
    at = SurfacePoint(0, int(gluing.borders.face[segment]), tuple(weights.tolist()))
    edge = np.diff(gluing.borders.ends[segment], axis=0)[0]
    outward = 0.02 * np.array([edge[1], -edge[0]]) / np.linalg.norm(edge)
    out, back = trace(gluing, at, map_.to_map(at) + outward), trace(gluing, at, map_.to_map(at) - outward)
    assert out.arrived
    assert back.arrived
    assert np.linalg.norm(map_.skin.position(out.pieces[-1].end) - map_.skin.position(at)) == pytest.approx(
        0.02, rel=0.05
    )
    assert len(back.pieces) == 1


def test_mirroring_the_chart_changes_nothing_on_the_body():
    plain = unrolled(cap(0.0001, rings=6))
    turned = TactileMap(plain.skin, plain.charts, MapLayout((Placement(mirrored=True),)))
    at = _start(plain, 0)
    step = 1e-6 * np.array([1.0, 0.5])
    ends = [trace(Gluing(m), at, m.to_map(at) + s).pieces[-1].end for m, s in ((plain, step), (turned, step * [-1, 1]))]
    np.testing.assert_allclose(*(plain.skin.position(end) for end in ends), atol=1e-12)

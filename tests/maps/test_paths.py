"""Paths on the map: traced over seams, drawn, split at borders, and laid on the skin."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.control.motion.command import CHOICES
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.seam_transitions import SeamTransitions
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.paths import (
    NEAR_PITCHES,
    RASTER_STEP,
    MapPath,
    PathProjection,
    back_project_inside,
    draw_path,
    path_about,
    split_at_borders,
    trace_path,
)
from tests.support.references import unrolled, walk
from tests.support.surfaces import cap, frustum, named, sheet, skin_of
from tests.support.touch import arm
from tests.support.two_plates import two_plates

TUBES = {
    "tube": lambda: frustum(0.03, 0.03, length=0.3, around=30, along=12),
    "cone": lambda: frustum(0.05, 0.02, length=0.2, around=30, along=12),
}


def _start(map_, seed):
    generator = np.random.default_rng(seed)
    face = int(generator.integers(len(map_.charts[0].faces)))
    return SurfacePoint(0, face, tuple(generator.dirichlet([2, 2, 2]).tolist()))


def _direction_on_body(map_, at, step):
    """Step on the body of a small step on the map, by the face's own corners."""
    corners = map_.skin.patches[0].surface.vertices[map_.skin.patches[0].surface.faces[at.face]]
    flat = map_.uv[0][map_.charts[0].faces[at.face]]
    share = np.linalg.solve((flat[1:] - flat[0]).T, step)
    return share @ (corners[1:] - corners[0])


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", sorted(TUBES))
@pytest.mark.parametrize("mirrored", [False, True])
def test_path_ends_where_a_straight_walk_ends(name, mirrored):
    surface = TUBES[name]()
    map_ = unrolled(surface, angle=1.1, mirrored=mirrored)
    transitions = SeamTransitions(map_)
    crossed = 0
    stopped = 0
    for seed in range(30):
        at = _start(map_, seed)
        turn = 0.21 * seed
        step = 0.25 * np.array([np.cos(turn), np.sin(turn)])
        end, _, left = walk(surface, at.face, map_.skin.position(at), _direction_on_body(map_, at, step), 0.25)
        path = trace_path(transitions, at, map_.to_map(at) + step)
        np.testing.assert_allclose(map_.skin.position(path.pieces[-1].end), end, atol=1e-9)
        assert np.linalg.norm(path.remaining) == pytest.approx(left, abs=1e-9)
        assert path.arrived == (left == 0)
        crossed = crossed + len(path.pieces) - 1
        stopped = stopped + (left > 0)
    assert crossed > 10
    assert 0 < stopped < 30


@pytest.mark.parametrize("name", ["hemisphere", "bumpy tube", "sphere"])
def test_pieces_follow_each_other_on_the_body(name):
    map_ = build_map(skin_of(named(name)))
    transitions = SeamTransitions(map_)
    crossed = 0
    for seed in range(20):
        at = _start(map_, seed)
        pieces = trace_path(transitions, at, map_.to_map(at) + 0.1 * np.array([np.cos(seed), np.sin(seed)])).pieces
        assert pieces[0].start == at
        for before, after in pairwise(pieces):
            np.testing.assert_allclose(map_.skin.position(after.start), map_.skin.position(before.end), atol=1e-12)
            assert np.linalg.norm(after.points[0] - before.points[1]) > 1e-6, "it went over a seam"
        for piece in pieces:
            for point, place in zip(piece.points, (piece.start, piece.end), strict=True):
                np.testing.assert_allclose(map_.to_map(place), point, atol=1e-9)
        crossed += len(pieces) - 1
    assert name == "hemisphere" or crossed > 3


def test_path_around_a_tube_returns_to_its_start():
    surface = frustum(0.03, 0.03, length=0.3, around=30, along=12)
    map_ = unrolled(surface, angle=0.3)
    at = _start(map_, 1)
    around = 30 * 2 * 0.03 * np.sin(np.pi / 30)
    along_tube = _on_map(map_, at, np.array([0, 0, 1.0]))
    across = np.array([-along_tube[1], along_tube[0]])
    path = trace_path(SeamTransitions(map_), at, map_.to_map(at) + 3 * around * across)
    assert len(path.pieces) == 4
    np.testing.assert_allclose(map_.skin.position(path.pieces[-1].end), map_.skin.position(at), atol=1e-9)


def _on_map(map_, at, direction):
    corners = map_.skin.patches[0].surface.vertices[map_.skin.patches[0].surface.faces[at.face]]
    flat = map_.uv[0][map_.charts[0].faces[at.face]]
    share = np.linalg.lstsq((corners[1:] - corners[0]).T, direction, rcond=None)[0]
    step = share @ (flat[1:] - flat[0])
    return step / np.linalg.norm(step)


def test_path_keeps_its_angles_beyond_the_seam():
    surface = frustum(0.05, 0.02, length=0.2, around=30, along=12)
    map_ = unrolled(surface)
    transitions = SeamTransitions(map_)
    at = _start(map_, 4)
    here = map_.to_map(at)
    steps = 0.04 * np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 2 * np.pi, 7)[:-1]])
    crossed = 0
    for shift in np.linspace(0, 0.25, 6):
        start = trace_path(transitions, at, here + [shift, 0.0]).pieces[-1].end if shift else at
        hexagon = map_.to_map(start) + np.cumsum(steps, axis=0)
        path = trace_path(transitions, start, hexagon)
        if path.arrived:
            np.testing.assert_allclose(map_.skin.position(path.pieces[-1].end), map_.skin.position(start), atol=1e-9)
            crossed += len(path.pieces) > 6
    assert crossed, "at least one hexagon must cross the seam"


def test_remainder_of_the_path_is_kept_at_the_end_of_the_skin():
    map_ = unrolled(sheet())
    at = SurfacePoint(0, 0, (0.3, 0.3, 0.4))
    path = trace_path(SeamTransitions(map_), at, map_.to_map(at) + [0.0, 5.0])
    (piece,) = path.pieces
    assert not path.arrived
    np.testing.assert_allclose(piece.points[1] + path.remaining, map_.to_map(at) + [0.0, 5.0], atol=1e-12)


def test_path_without_length_has_no_piece():
    map_ = unrolled(sheet())
    at = SurfacePoint(0, 0, (0.3, 0.3, 0.4))
    path = trace_path(SeamTransitions(map_), at, map_.to_map(at))
    assert (path.pieces, path.arrived) == ((), True)


def test_path_that_is_not_finite_is_rejected():
    map_ = unrolled(sheet())
    with pytest.raises(MapError, match="finite"):
        trace_path(SeamTransitions(map_), SurfacePoint(0, 0, (1.0, 0.0, 0.0)), np.array([np.nan, 0]))


def test_path_may_start_on_the_seam():
    surface = frustum(0.03, 0.03, length=0.3, around=30, along=12)
    map_ = unrolled(surface)
    transitions = SeamTransitions(map_)
    segment = int(np.flatnonzero(transitions.borders.partner >= 0)[3])
    weights = np.zeros(3)
    side = int(transitions.borders.side[segment])
    weights[[side, (side + 1) % 3]] = 0.4, 0.6
    at = SurfacePoint(0, int(transitions.borders.face[segment]), tuple(weights.tolist()))
    edge = np.diff(transitions.borders.ends[segment], axis=0)[0]
    outward = 0.02 * np.array([edge[1], -edge[0]]) / np.linalg.norm(edge)
    out = trace_path(transitions, at, map_.to_map(at) + outward)
    back = trace_path(transitions, at, map_.to_map(at) - outward)
    assert out.arrived
    assert back.arrived
    assert np.linalg.norm(map_.skin.position(out.pieces[-1].end) - map_.skin.position(at)) == pytest.approx(
        0.02, rel=0.05
    )
    assert len(back.pieces) == 1


def test_mirroring_the_chart_does_not_change_the_path_on_the_body():
    plain = unrolled(cap(0.0001, rings=6))
    turned = TactileMap(plain.skin, plain.charts, MapLayout((Placement(mirrored=True),)))
    at = _start(plain, 0)
    step = 1e-6 * np.array([1.0, 0.5])
    ends = [
        trace_path(SeamTransitions(m), at, m.to_map(at) + s).pieces[-1].end
        for m, s in ((plain, step), (turned, step * [-1, 1]))
    ]
    np.testing.assert_allclose(*(plain.skin.position(end) for end in ends), atol=1e-12)


CORNERS = np.array([[0.0, 0.0], [0.03, 0.0], [0.03, 0.04]])


def test_polyline_is_traversed_by_arc_length():
    path = draw_path("polyline", CORNERS)
    assert path.length == pytest.approx(0.07)
    point, direction = path.at(0.05)
    assert point == pytest.approx([0.03, 0.02])
    assert direction == pytest.approx([0, 1])
    assert path.at(-1.0)[0] == pytest.approx(CORNERS[0])
    assert path.at(0.08)[0] == pytest.approx(CORNERS[-1])
    assert not path.at(0.08)[1].any()
    assert not path.closed


def test_repeated_points_are_omitted():
    path = MapPath(np.repeat(CORNERS, 3, axis=0))
    assert len(path.points) == 3
    assert path.length == pytest.approx(0.07)


@pytest.mark.parametrize("kind", CHOICES["path_kind"])
def test_every_kind_of_path_is_traversed_at_constant_speed(kind):
    path = draw_path(kind, CORNERS)
    ways = np.linspace(0, path.length, 500, endpoint=False)
    points = np.array([path.at(way)[0] for way in ways])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() <= ways[1] * (1 + 1e-9)
    assert np.median(steps) == pytest.approx(ways[1], rel=1e-3)
    assert np.isfinite(points).all()


def test_spline_goes_through_its_points_and_closes_smoothly():
    path = draw_path("spline", CORNERS)
    for corner in CORNERS:
        assert np.linalg.norm(path.points - corner, axis=1).min() < 1e-3
    ring = draw_path("spline", [*CORNERS, CORNERS[0]])
    assert ring.closed
    before = ring.at(ring.length * (1 - 1e-6))[1]
    after = ring.at(0.0)[1]
    assert before @ after > 0.99


def test_figure_of_eight_starts_in_its_middle_crosses_it_and_closes():
    path = draw_path("lemniscate", [[-0.02, 0.0], [0.02, 0.0]])
    assert path.closed
    assert path.points.max(axis=0) == pytest.approx([0.02, 0.01], rel=1e-2)
    assert path.at(0.0)[0] == pytest.approx([0, 0], abs=1e-9)
    assert path.at(path.length / 2)[0] == pytest.approx([0, 0], abs=1e-3)


def test_raster_leaves_no_gap_and_never_jumps():
    path = draw_path("raster", [[0.03, 0.04], [0.0, 0.0]])
    rows = np.unique(path.points[:, 1])
    assert np.diff(rows).max() <= RASTER_STEP
    assert np.ptp(path.points, axis=0) == pytest.approx([0.03, 0.04])
    assert np.linalg.norm(np.diff(path.points, axis=0), axis=1).max() <= 0.03 + 1e-12


@pytest.mark.parametrize("kind", CHOICES["path_kind"])
def test_path_is_placed_about_a_point(kind):
    path = path_about(kind, np.array([0.5, 0.2]), 0.03)
    assert np.ptp(path.points, axis=0).max() == pytest.approx(0.03, rel=0.02)
    middle = (path.points.max(axis=0) + path.points.min(axis=0)) / 2
    assert middle == pytest.approx([0.5, 0.2], abs=1e-3)


@pytest.mark.parametrize("bad", [[], [[0.0, 0.0]], [[0.0, 0.0], [np.nan, 0.0]], [[0.0, 0.0], [np.inf, 1.0]]])
def test_invalid_path_is_rejected(bad):
    with pytest.raises(MapError, match="path needs"):
        draw_path("polyline", bad)
    with pytest.raises(MapError, match="too far from the origin"):
        draw_path("spline", [[0.0, 0.0], [1e300, 0.0]])


MAP = two_plates()
TRANSITIONS = SeamTransitions(MAP)


def cut(*points):
    return split_at_borders(np.array(points, dtype=float), TRANSITIONS)


def test_path_inside_a_patch_is_one_run():
    [run] = cut((0.01, 0.01), (0.05, 0.09), (0.09, 0.01))
    assert run.patch == 0
    assert run.points[[0, -1]] == pytest.approx(np.array([[0.01, 0.01], [0.09, 0.01]]))


def test_path_between_patches_has_a_run_in_each():
    runs = cut((0.05, 0.05), (0.30, 0.05))
    assert [run.patch for run in runs] == [0, None, 1, None]
    assert [run.points[0][0] for run in runs] == pytest.approx([0.05, 0.10, 0.12, 0.22])
    assert runs[-1].points[-1] == pytest.approx([0.30, 0.05])


def test_path_that_leaves_and_reenters_over_the_same_border_is_split():
    assert [run.patch for run in cut((0.05, 0.05), (0.05, -0.01), (0.06, -0.01), (0.06, 0.05))] == [0, None, 0]


def test_single_point_has_no_runs():
    assert cut((0.05, 0.05)) == ()
    assert split_at_borders(np.array([[0.05, 0.05], [0.05, 0.05 + 1e-10]]), TRANSITIONS) == ()


def test_path_off_the_skin_is_one_outside_run():
    assert [run.patch for run in cut((9.0, 9.0), (9.1, 9.0))] == [None]


@pytest.mark.sampled(3)
@pytest.mark.parametrize("seed", range(6))
def test_runs_make_up_the_polygon_and_have_correct_places(seed):
    """Walks of 40 sides all over the map of our arm, which is cut open by seams."""
    map_ = arm().map
    low, high = map_.bounds
    points = np.random.default_rng(seed).uniform(low - 0.05, high + 0.05, (40, 2))
    runs = split_at_borders(points, SeamTransitions(map_))
    assert len(runs) > 20, "it must come in and leave"
    length = sum(np.linalg.norm(np.diff(run.points, axis=0), axis=1).sum() for run in runs)
    assert length == pytest.approx(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    for before, after in pairwise(runs):
        assert before.points[-1] == pytest.approx(after.points[0])
        assert before.patch != after.patch
    for run in runs:
        shares = np.linspace(0.01, 0.99, 9)[:, None]
        for start, end in zip(run.points[:-1], run.points[1:], strict=True):
            assert set(map_.to_body_many(start + shares * (end - start))[0]) == {-1 if run.patch is None else run.patch}


def walked(*points, drawn=True, transitions=TRANSITIONS) -> PathProjection:
    points = np.array(points, dtype=float)
    return PathProjection(transitions, transitions.map.to_body(points[0]), points, drawn=drawn)


def ends(walk):
    return np.array([piece.points for piece in walk.pieces]).reshape(-1, 4)


def test_path_inside_a_patch_has_the_drawn_sides_as_pieces():
    walk = walked((0.01, 0.01), (0.05, 0.09), (0.09, 0.01))
    assert ends(walk) == pytest.approx(np.array([[0.01, 0.01, 0.05, 0.09], [0.05, 0.09, 0.09, 0.01]]))
    assert walk.whole
    assert walk.jumps == []
    for piece in walk.pieces:
        assert MAP.to_map(piece.start) == pytest.approx(piece.points[0], abs=1e-6)
        assert MAP.to_map(piece.end) == pytest.approx(piece.points[1], abs=1e-6)


def test_path_jumps_between_patches_and_stops_at_the_end_of_the_skin():
    walk = walked((0.05, 0.05), (0.30, 0.05))
    assert [piece.patch for piece in walk.pieces] == [0, 1]
    assert walk.jumps == [1]
    assert not walk.whole
    kept = walked((0.05, 0.05), (0.30, 0.05), drawn=False)
    assert [piece.patch for piece in kept.pieces] == [0]
    assert kept.jumps == []


def test_path_that_starts_outside_begins_at_its_entry():
    walk = walked((0.10, 0.05), (0.13, 0.05))
    assert [piece.patch for piece in walk.pieces] == [1]
    assert walk.jumps == []


@pytest.mark.parametrize("drawn", [True, False])
@pytest.mark.parametrize("taxel", [10, 60, 150, 250])
def test_pieces_are_continuous_on_the_body_except_at_jumps(taxel, drawn):
    map_ = arm().map
    turn = np.linspace(0, 2 * np.pi, 60)
    ring = map_.taxel_points[taxel] + 0.12 * np.stack([np.sin(turn), np.cos(turn) - 1], axis=1)
    walk = walked(*ring, drawn=drawn, transitions=SeamTransitions(map_))
    skin = map_.skin
    assert len(walk.pieces) > 3
    for number, (before, after) in enumerate(pairwise(walk.pieces), start=1):
        away = np.linalg.norm(skin.position(before.end) - skin.position(after.start))
        if number in walk.jumps:
            assert before.end.patch != after.start.patch or away > 1e-6
        else:
            assert before.end.patch == after.start.patch
            assert away < NEAR_PITCHES * np.sqrt(skin.areas.mean()) + 1e-6


def test_point_within_rounding_of_the_border_is_on_the_patch():
    at = back_project_inside(MAP, 0, np.array([0.05, 0.05]), np.array([0.1 + 1e-11, 0.05]))
    assert at.patch == 0
    with pytest.raises(MapError, match="no skin at this point"):
        back_project_inside(MAP, 1, np.array([0.05, 0.05]), np.array([0.06, 0.05]))

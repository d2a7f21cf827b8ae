"""No point near a body is ever missing, whatever is remembered of earlier questions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.broadphase import (
    FACING,
    TILT,
    CachedNeighbourhood,
    CellGrid,
    LinkBroadphase,
    link_broadphases,
)
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Load, MeshShape, Plane, Sphere, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
from tests.support.touch import arm, bar_skin, pair

POSITIONS = np.random.default_rng(0).uniform(-0.1, 0.1, size=(700, 3)) * [1, 1, 0.2]


@pytest.mark.parametrize("size", [1e-4, 0.01, 0.05, 10.0])
def test_every_point_is_in_one_cell_and_no_closer_to_a_body_than_its_cell(size):
    cells = CellGrid(POSITIONS, size)
    turned = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    load = Load("link", np.zeros(3), np.array([0.0, 0, 1]), 1.0, Box((0.02, 0.01, 0.03)), Pose(turned, [0.05, 0, 0.01]))
    lowest = cells.lowest(load)
    members = [cells.order[cells.members(np.array([cell]))] for cell in range(len(lowest))]
    np.testing.assert_array_equal(np.sort(np.concatenate(members)), np.arange(len(POSITIONS)))
    distances = load.distances(POSITIONS)
    assert all(distances[points].min() >= low - 1e-12 for points, low in zip(members, lowest, strict=True))
    np.testing.assert_array_equal(cells.members(np.arange(len(lowest))), np.arange(len(POSITIONS)))


NORMAL = np.array([0.0, 0, 1])
GRID = np.stack([k.ravel() for k in np.meshgrid(np.linspace(-0.02, 0.02, 9), np.linspace(-0.02, 0.02, 9), [0.0])], 1)
BALL = Sphere(0.01)
BOX = Box((0.01, 0.01, 0.01))


def load(shape, *, at=(0, 0, 0.01), normal=NORMAL, turn=(0, 0, 0), point=(0, 0, 0)):
    pose = Pose(Rotation.from_rotvec(turn).as_matrix(), np.asarray(at, dtype=float))
    return Load("link", np.asarray(point, dtype=float), np.asarray(normal), 1.0, shape, pose)


def near(shape, normals=None) -> CachedNeighbourhood:
    normals = np.tile(NORMAL, (len(GRID), 1)) if normals is None else normals
    return CachedNeighbourhood(
        load(shape),
        0.2,
        np.arange(len(GRID)),
        GRID,
        normals,
        np.ones(len(GRID)),
        cutoff=0.01,
        slack=0.002,
        depth=0.0,
        extent=0.03,
    )


def test_cached_points_are_valid_until_the_slack_with_a_shrinking_radius():
    ball = near(BALL)
    assert ball.search_radius == 0.01
    assert ball.holds(load(BALL, at=(0.0015, 0, 0.01)), 0.2)
    assert ball.search_radius == pytest.approx(0.0085)
    assert not ball.holds(load(BALL, at=(0.0015, 0.0015, 0.01)), 0.2)
    assert ball.holds(load(BALL), 0.2)
    assert ball.search_radius == 0.01


def test_box_rolling_about_its_contact_hardly_shrinks_the_search_radius():
    turn = 0.02
    rolled = Rotation.from_rotvec((turn, 0, 0)).as_matrix() @ [0, 0, 0.01]
    box = near(BOX)
    assert box.holds(load(BOX, at=rolled, turn=(turn, 0, 0)), 0.2)
    assert box.search_radius > 0.01 - 1.5 * 0.03 * turn


def test_bodies_normals_and_radii_have_separate_neighbourhoods():
    ball = near(BALL)
    assert ball.holds(load(Sphere(0.01)), 0.2), "an equal ball is the same"
    assert not ball.holds(load(Sphere(0.011)), 0.2)
    assert not ball.holds(load(BALL), -0.2)
    tilted = np.array([np.sin(1.1 * TILT), 0, np.cos(1.1 * TILT)])
    assert not ball.holds(load(BALL, normal=tilted), 0.2)


def test_point_that_faces_away_is_not_near():
    normals = np.tile(NORMAL, (len(GRID), 1))
    normals[0] = [np.sqrt(1 - 0.21**2), 0, 0.21]
    ball = near(BALL, normals)
    assert np.isfinite(ball.distances(load(BALL))).all()
    away = np.array([-np.sin(0.03), 0, np.cos(0.03)])
    distances = ball.distances(load(BALL, normal=away))
    assert distances[0] == np.inf
    assert np.isfinite(distances[1:]).all()


SKIN = arm().skin
LINK = "forearm"
UP = np.array([0.0, 0.0, 1.0])
SOLID = trimesh.creation.torus(0.03, 0.01, major_sections=24, minor_sections=10)
SHAPES = {
    "ball": lambda: Sphere(0.01),
    "box": lambda: Box((0.02, 0.01, 0.015)),
    "cylinder": lambda: Cylinder(0.01, 0.03),
    "plane": Plane,
    "mesh": lambda: MeshShape(Mesh(SOLID.vertices, SOLID.faces)),
}


def link_points():
    points = quadrature_points(SKIN)
    covered = np.array([patch.link == LINK for patch in SKIN.patches])
    here = np.flatnonzero(covered[SKIN.patch_of[points.taxel]])
    return here, points.positions[here], points.normals[here]


def wander(shape, seed: int, steps: int = 120) -> Iterator[Load]:
    """A body that presses somewhere, slides, turns and sometimes jumps."""
    generator = np.random.default_rng(seed)
    _, positions, normals = link_points()
    place = generator.integers(len(positions))
    rotation = Rotation.random(random_state=seed)
    offset = np.zeros(3)
    for step in range(steps):
        if step % 40 == 39:
            place = generator.integers(len(positions))
            offset = np.zeros(3)
        offset = offset + generator.normal(scale=4e-4, size=3)
        rotation = Rotation.from_rotvec(generator.normal(scale=5e-3, size=3)) * rotation
        normal = normals[place] + generator.normal(scale=0.02, size=3)
        normal /= np.linalg.norm(normal)
        away = 0.0 if isinstance(shape, Plane) else 0.6 * shape.reach
        turned = Rotation.align_vectors([-normal], [UP])[0] * rotation**0.05 if isinstance(shape, Plane) else rotation
        centre = positions[place] + offset + away * normal
        yield Load(LINK, positions[place] + offset, normal, 1.0, shape, Pose(turned.as_matrix(), centre))


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_all_points_within_the_stated_radius_are_found(kind, seed):
    shape = SHAPES[kind]()
    bed = LinkBroadphase(SKIN, LINK)
    here, positions, normals = link_points()
    found = 0
    for load in wander(shape, seed):
        under = bed.near(load)
        distances = load.distances(positions)
        facing = normals @ load.normal > FACING
        if under is None:
            assert distances[facing].min(initial=np.inf) > bed.contact_range
            continue
        found += 1
        known = under.distances < np.inf
        np.testing.assert_array_equal(np.isin(here, under.points[known]) & ~facing, False)
        assert len(np.unique(under.points)) == len(under.points)
        close = here[facing & (distances < under.search_radius)]
        assert np.isin(close, under.points[known]).all()
        assert under.distances.min() == pytest.approx(distances[facing].min(), abs=1e-12)
        own = np.searchsorted(here, under.points[known])
        assert under.distances[known] == pytest.approx(distances[own], abs=1e-12)
    assert found > 60


@pytest.mark.parametrize("upto", [1e-3, 0.02, 0.3, 1e12])
def test_points_up_to_a_requested_distance_are_returned(upto):
    bed = LinkBroadphase(SKIN, LINK)
    here, positions, normals = link_points()
    load = sphere_load(LINK, positions[50], normals[50], 1.0, 0.01)
    assert bed.near(load) is not None
    under = bed.near(load, upto=upto)
    assert under.search_radius >= upto
    expected = here[(normals @ load.normal > FACING) & (load.distances(positions) < upto)]
    assert expected.size
    assert np.isin(expected, under.points).all()


def test_slow_body_needs_one_search():
    bed = LinkBroadphase(SKIN, LINK)
    shape = Sphere(0.01)
    _, positions, normals = link_points()
    at = positions[50] + 0.01 * normals[50]
    normal = normals[50]
    points = {
        id(bed.near(Load(LINK, at, normal, 1.0, shape, Pose(np.eye(3), at + k * 2e-5 * UP))).points) for k in range(20)
    }
    assert len(points) == 1
    far = bed.near(Load(LINK, at, normal, 1.0, shape, Pose(np.eye(3), at + 0.02 * UP)))
    assert id(far.points) not in points


def test_cache_of_many_bodies_is_bounded():
    bed = LinkBroadphase(SKIN, LINK)
    _, positions, normals = link_points()
    for number in range(0, len(positions), len(positions) // 200):
        bed.near(sphere_load(LINK, positions[number], normals[number], 1.0, 0.01))
    assert len(bed._near) <= 32
    five = [sphere_load(LINK, positions[k], normals[k], 1.0, 0.01) for k in range(0, 500, 100)]
    first = [id(bed.near(load).points) for load in five]
    assert first == [id(bed.near(load).points) for load in five]


def test_load_outside_or_at_the_edge_of_the_skin_has_no_point():
    skin = bar_skin()
    bed = LinkBroadphase(skin, "bar")
    points = quadrature_points(skin)
    for away in (0.2, 0.1, 0.2):
        nearby = sphere_load("bar", np.array([-away, 0, 0.02]), UP, 1.0, 0.008)
        assert bed.near(nearby) is None
        assert bed.nearest(nearby) is None
    edge = sphere_load("bar", np.array([0.005, 0, 0.02]), np.array([-1.0, 0, 0]), 1.0, 0.008)
    assert bed.near(edge) is None, "no point looks that way"
    nearest = bed.nearest(edge)
    assert nearest == edge.distances(points.positions).argmin()
    below = sphere_load("bar", np.array([0.2, 0, 0.015]), -UP, 1.0, 0.008)
    assert bed.nearest(below) is None, "the skin on the other side is not pressed"


def test_range_of_a_body_does_not_depend_on_its_history():
    skin = bar_skin()
    bed = LinkBroadphase(skin, "bar")
    floating = [
        sphere_load("bar", np.array([0.2, 0, 0.02]), UP, 1.0, 0.05, depth=-bed.contact_range - gap)
        for gap in (-1e-3, 1e-3, -1e-3, 0.02, 1e-3, -1e-3)
    ]
    assert [bed.near(load) is None for load in floating] == [False, True, False, True, True, False]


def test_invalid_pose_is_rejected():
    skin = bar_skin()
    load = Load("bar", np.zeros(3), UP, 1.0, Sphere(0.01), Pose(np.eye(3), np.array([0, np.nan, 0])))
    with pytest.raises(SimulationError, match=r"on bar: the pose of a body is not finite.*nan"):
        LinkBroadphase(skin, "bar").near(load)


def test_every_link_with_points_has_a_broadphase():
    _, skin = pair()
    found = link_broadphases(skin)
    assert list(found) == ["left", "right"]
    count = len(quadrature_points(skin).areas)
    np.testing.assert_array_equal(np.concatenate([np.sort(bed.points) for bed in found.values()]), np.arange(count))
    assert link_broadphases(Skin(())) == {}

"""What lies under a body: everything, whatever was asked before."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from app.errors import SimulationError
from app.geometry.mesh import Mesh
from app.geometry.pose import Pose
from app.skin.skin import Patch, Skin
from app.touch.bed import FACING, Bed, beds
from app.touch.load import Load, ball_load
from app.touch.mesh_shape import MeshShape
from app.touch.points import skin_points
from app.touch.shapes import Ball, Box, Cylinder, Plane
from tests.touch import arm, bar_skin, pair

SKIN = arm().skin
LINK = "forearm"
UP = np.array([0.0, 0.0, 1.0])
SOLID = trimesh.creation.torus(0.03, 0.01, major_sections=24, minor_sections=10)
SHAPES = {
    "ball": lambda: Ball(0.01),
    "box": lambda: Box((0.02, 0.01, 0.015)),
    "cylinder": lambda: Cylinder(0.01, 0.03),
    "plane": Plane,
    "mesh": lambda: MeshShape(Mesh(SOLID.vertices, SOLID.faces)),
}


def link_points():
    points = skin_points(SKIN)
    wears = np.array([patch.link == LINK for patch in SKIN.patches])
    here = np.flatnonzero(wears[SKIN.patch_of[points.taxel]])
    return here, points.positions[here], points.normals[here]


def wander(shape, seed: int, steps: int = 120) -> Iterator[Load]:
    """A body that presses somewhere, slides, turns and sometimes jumps."""
    generator = np.random.default_rng(seed)
    _, positions, normals = link_points()
    place, rotation = generator.integers(len(positions)), Rotation.random(random_state=seed)
    offset = np.zeros(3)
    for step in range(steps):
        if step % 40 == 39:
            place, offset = generator.integers(len(positions)), np.zeros(3)
        offset = offset + generator.normal(scale=4e-4, size=3)
        rotation = Rotation.from_rotvec(generator.normal(scale=5e-3, size=3)) * rotation
        normal = normals[place] + generator.normal(scale=0.02, size=3)
        normal /= np.linalg.norm(normal)
        away = 0.0 if isinstance(shape, Plane) else 0.6 * shape.reach
        turned = Rotation.align_vectors([-normal], [UP])[0] * rotation**0.05 if isinstance(shape, Plane) else rotation
        centre = positions[place] + offset + away * normal
        yield Load(LINK, positions[place] + offset, normal, 1.0, shape, Pose(turned.as_matrix(), centre))


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("seed", [0, 1])
def test_nothing_is_missing_below_what_is_promised(kind, seed):
    shape = SHAPES[kind]()
    bed = Bed(SKIN, LINK)
    here, positions, normals = link_points()
    found = 0
    for load in wander(shape, seed):
        under = bed.under(load)
        distances = load.distances(positions)
        facing = normals @ load.normal > FACING
        if under is None:
            assert distances[facing].min(initial=np.inf) > bed.beside
            continue
        found += 1
        known = under.distances < np.inf
        np.testing.assert_array_equal(np.isin(here, under.points[known]) & ~facing, False)
        assert len(np.unique(under.points)) == len(under.points)
        close = here[facing & (distances < under.complete)]
        assert np.isin(close, under.points[known]).all()
        assert under.distances.min() == pytest.approx(distances[facing].min(), abs=1e-12)
        own = np.searchsorted(here, under.points[known])
        assert under.distances[known] == pytest.approx(distances[own], abs=1e-12)
    assert found > 60


@pytest.mark.parametrize("upto", [1e-3, 0.02, 0.3, 1e12])
def test_points_up_to_any_distance_are_there_when_asked_for(upto):
    bed = Bed(SKIN, LINK)
    here, positions, normals = link_points()
    load = ball_load(LINK, positions[50], normals[50], 1.0, 0.01)
    assert bed.under(load) is not None
    under = bed.under(load, upto=upto)
    assert under.complete >= upto
    wanted = here[(normals @ load.normal > FACING) & (load.distances(positions) < upto)]
    assert wanted.size
    assert np.isin(wanted, under.points).all()


def test_a_body_that_stands_or_creeps_is_searched_for_once():
    bed, shape = Bed(SKIN, LINK), Ball(0.01)
    _, positions, normals = link_points()
    at, normal = positions[50] + 0.01 * normals[50], normals[50]
    points = {
        id(bed.under(Load(LINK, at, normal, 1.0, shape, Pose(np.eye(3), at + k * 2e-5 * UP))).points) for k in range(20)
    }
    assert len(points) == 1
    far = bed.under(Load(LINK, at, normal, 1.0, shape, Pose(np.eye(3), at + 0.02 * UP)))
    assert id(far.points) not in points


def test_many_bodies_are_remembered_and_memory_does_not_grow():
    bed = Bed(SKIN, LINK)
    _, positions, normals = link_points()
    for number in range(0, len(positions), len(positions) // 200):
        bed.under(ball_load(LINK, positions[number], normals[number], 1.0, 0.01))
    assert len(bed._near) <= 32
    five = [ball_load(LINK, positions[k], normals[k], 1.0, 0.01) for k in range(0, 500, 100)]
    first = [id(bed.under(load).points) for load in five]
    assert first == [id(bed.under(load).points) for load in five]


def test_beside_the_skin_nothing_is_under_and_on_its_edge_the_nearest_point_is():
    skin = bar_skin()
    bed, points = Bed(skin, "bar"), skin_points(skin)
    for away in (0.2, 0.1, 0.2):
        beside = ball_load("bar", np.array([-away, 0, 0.02]), UP, 1.0, 0.008)
        assert bed.under(beside) is None
        assert bed.nearest(beside) is None
    edge = ball_load("bar", np.array([0.005, 0, 0.02]), np.array([-1.0, 0, 0]), 1.0, 0.008)
    assert bed.under(edge) is None, "no point looks that way"
    nearest = bed.nearest(edge)
    assert nearest == edge.distances(points.positions).argmin()
    below = ball_load("bar", np.array([0.2, 0, 0.015]), -UP, 1.0, 0.008)
    assert bed.nearest(below) is None, "the skin on the other side is not pressed"


def test_how_far_off_a_body_is_felt_does_not_depend_on_where_it_was():
    skin = bar_skin()
    bed = Bed(skin, "bar")
    floating = [ball_load("bar", np.array([0.2, 0, 0.02]), UP, 1.0, 0.05, depth=-bed.beside - gap)
                for gap in (-1e-3, 1e-3, -1e-3, 0.02, 1e-3, -1e-3)]  # fmt: skip
    assert [bed.under(load) is None for load in floating] == [False, True, False, True, True, False]


def test_a_body_that_is_nowhere_is_refused():
    skin = bar_skin()
    load = Load("bar", np.zeros(3), UP, 1.0, Ball(0.01), Pose(np.eye(3), np.array([0, np.nan, 0])))
    with pytest.raises(SimulationError, match=r"on bar: a body is nowhere.*nan"):
        Bed(skin, "bar").under(load)


def test_there_is_a_bed_for_each_link_that_wears_points():
    _, skin = pair()
    found = beds(skin)
    assert list(found) == ["left", "right"]
    count = len(skin_points(skin).areas)
    np.testing.assert_array_equal(np.concatenate([np.sort(bed.points) for bed in found.values()]), np.arange(count))
    assert beds(Skin(())) == {}


def test_two_patches_of_one_link_are_one_bed():
    skin = bar_skin()
    patch = skin.patches[0]
    both = Skin((patch, Patch("again", "bar", patch.surface, patch.taxels)))
    assert len(Bed(both, "bar").points) == 2 * len(Bed(skin, "bar").points)

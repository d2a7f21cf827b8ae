"""Whatever presses the skin, force is conserved, no frame is special and every number means something."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from app.geometry.mesh import Mesh
from app.geometry.pose import Pose
from app.skin.skin import Patch, Skin
from app.skin.taxels import Quadrature, Taxels
from app.touch.fill import fill
from app.touch.load import Load
from app.touch.mesh_shape import MeshShape
from app.touch.models.point import Point
from app.touch.models.water_fill import WaterFill
from app.touch.shapes import Ball, Box, Cylinder, Plane
from tests.touch import arm

SKIN = arm().skin
forces = st.one_of(st.just(0.0), st.just(5e-324), st.floats(1e-300, 1e-6), st.floats(1e-6, 1e3), st.floats(1e3, 1e290))
sizes = st.floats(1e-3, 0.1)


def _solids() -> list[Mesh]:
    """A ring, a box, and a link of the arm that its other links may touch."""
    solids = [trimesh.creation.torus(0.03, 0.01, major_sections=16, minor_sections=8),
              trimesh.creation.box((0.05, 0.02, 0.03))]  # fmt: skip
    link = next(link for link in arm().robot.links if link.name == SKIN.patches[0].link)
    return [*(Mesh(solid.vertices, solid.faces) for solid in solids), link.mesh]


@pytest.fixture(scope="module")
def models():
    """Both models, each used for all examples: what they remember must not matter."""
    return WaterFill(SKIN), Point(SKIN)


shapes = st.one_of(
    st.builds(Ball, st.floats(1e-4, 0.1)),
    st.builds(lambda x, y, z: Box((x, y, z)), sizes, sizes, sizes),
    st.builds(Cylinder, sizes, sizes),
    st.just(Plane()),
    st.builds(MeshShape, st.sampled_from(_solids())),
)


@st.composite
def loads(draw, forces=forces):
    """A body of any kind, turned any way, that touches the skin somewhere."""
    at = SKIN.taxel_point(draw(st.integers(0, len(SKIN) - 1)))
    point, normal, shape = SKIN.position(at), SKIN.normal(at), draw(shapes)
    turn = Rotation.random(random_state=draw(st.integers(0, 1000)))
    if isinstance(shape, Plane):
        turn = Rotation.align_vectors([-normal], [[0, 0, 1]])[0]
    elif not isinstance(shape, MeshShape):  # from its middle against the normal to its surface
        inward = turn.inv().apply(-normal)
        point = point - turn.apply(_surface_along(shape, inward))
    else:
        vertices = shape.mesh.vertices @ turn.as_matrix().T
        point = point - vertices[(vertices @ normal).argmin()]
    return Load(SKIN.link(at), SKIN.position(at), normal, draw(forces), shape, Pose(turn.as_matrix(), point))


def _surface_along(shape, direction):
    """The point at which a ray from the middle of a body leaves it."""
    low, high = 0.0, 2 * shape.reach
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shape.distance(middle * direction[None])[0] < 0 else (low, middle)
    return low * direction


@given(load=loads(), which=st.integers(0, 1))
@settings(max_examples=300, deadline=None)
def test_the_sum_of_pressure_times_area_is_the_force(models, load, which):
    model = models[which]
    pressures = model.pressures([load])
    assert model.notes == ()
    assert np.isfinite(pressures).all()
    assert (pressures >= 0).all()
    if load.force > 1e-290:  # below, rounding is no longer relative
        assert abs(pressures @ SKIN.areas / load.force - 1) < 1e-12


@given(several=st.lists(loads(st.floats(1e-3, 1e3)), min_size=1, max_size=5), which=st.integers(0, 1))
@settings(max_examples=60, deadline=None)
def test_several_loads_add_up(models, several, which):
    model = models[which]
    together, apart = model.pressures(several), sum(model.pressures([load]) for load in several)
    np.testing.assert_allclose(together, apart, rtol=1e-12)
    assert abs(together @ SKIN.areas / sum(load.force for load in several) - 1) < 1e-12


@given(load=loads(st.floats(1e-3, 1e3)), seed=st.integers(0, 50), away=st.floats(0, 2.0))
@settings(max_examples=60, deadline=None)
def test_a_link_moved_with_all_that_presses_it_feels_the_same(load, seed, away):
    motion = Pose(Rotation.random(random_state=seed).as_matrix(), np.array([away, -0.3, 0.1]))
    patches = tuple(_moved(patch, motion) for patch in SKIN.patches if patch.link == load.link)
    moved = Load(load.link, motion.points(load.point), motion.directions(load.normal), load.force, load.shape,
                 motion @ load.pose)  # fmt: skip
    still = Skin(tuple(patch for patch in SKIN.patches if patch.link == load.link))
    expected = WaterFill(still).pressures([load])
    assert expected.max() > 0
    # Rounding in metres, times the stiffness of the bed and what a level is off by that wets one point more.
    np.testing.assert_allclose(WaterFill(Skin(patches)).pressures([moved]), expected, rtol=1e-7, atol=1e-4)


def _moved(patch: Patch, motion: Pose) -> Patch:
    taxels, points = patch.taxels, patch.taxels.quadrature
    quadrature = Quadrature(
        motion.points(points.positions), motion.directions(points.normals), points.areas, points.taxel
    )
    surface = Mesh(motion.points(patch.surface.vertices), patch.surface.faces)
    moved = Taxels(motion.points(taxels.positions), motion.directions(taxels.normals), taxels.faces, taxels.weights,
                   taxels.areas, taxels.neighbours, quadrature)  # fmt: skip
    return Patch(patch.name, patch.link, surface, moved)


@given(
    floors=st.lists(st.tuples(st.floats(0, 0.1), st.floats(1e-9, 1e-3)), min_size=1, max_size=60),
    volume=st.floats(1e-12, 1.0),
)
@settings(max_examples=300, deadline=None)
def test_the_level_of_water_is_that_of_bisection(floors, volume):
    gaps, areas = np.array(floors).T
    low, high = gaps.min(), gaps.max() + volume / areas.min() + 1.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if areas @ np.maximum(middle - gaps, 0) < volume else (low, middle)
    level = fill(gaps, areas, volume).level
    assert abs(level - high) <= 1e-9 * max(abs(high), 1.0)
    assert abs(areas @ np.maximum(level - gaps, 0) - volume) <= 1e-9 * max(volume, areas.sum())

"""The hulls of links with skin."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import mujoco
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tactile_maps.core.errors import Finding
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.robots.model.mujoco_spec import compile_spec
from tactile_maps.skin.link_hulls import corners_with_faces, hull_name, hull_points, hulls_spec
from tactile_maps.skin.model.skin import PLACEHOLDER_COVERED
from tests.support.touch import arm, pair


def test_hull_contains_link_and_skin_vertices():
    robot, skin = pair()
    assert len(hull_points(robot, skin, "left")) == len(skin.patches[0].surface.vertices) + 8


def lost(covered):
    """Two blocks with flat skin; a placeholder is in place of the left one, and is covered where stated."""
    robot, skin = pair()
    left = replace(robot.links[0], mesh=box_mesh(0.02), missing=("block",))
    notes = (Finding(PLACEHOLDER_COVERED, "left", "covered"), Finding("other", "left", "noticed"))
    return replace(robot, links=(left, robot.links[1])), replace(skin, findings=notes[not covered :])


def test_placeholder_of_a_missing_mesh_is_in_the_hull_only_if_covered():
    bare, covered = (hull_points(*lost(covered=covered), "left")[:, 0].min() for covered in (False, True))
    assert covered == -0.01
    assert bare == pytest.approx(0.05 - 0.003), "a plate under the skin at 0.05"
    robot, skin = lost(covered=True)
    other = replace(skin.findings[0], where="right")
    assert hull_points(robot, replace(skin, findings=(other,)), "left")[:, 0].min() > 0, "another link is covered"


def faces_of_corners(points):
    """Return the number of faces of each corner of the hull of points, as MuJoCo merges them."""
    spec = mujoco.MjSpec()
    inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    spec.add_mesh(name="hull", uservert=points.ravel().tolist(), inertia=inertia)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hull")
    model = spec.compile()
    count = model.mesh_graph[0]
    return model.mesh_polymapnum[model.mesh_graph[2 + count : 2 + 2 * count]]


def test_each_corner_of_an_almost_flat_hull_has_a_face():
    """The points of a flat skin are in a plane to within float32, and some of them are corners of the hull."""
    x, y = np.meshgrid(np.linspace(-0.06, 0.06, 25), np.linspace(-0.06, 0.06, 25))
    above = np.random.default_rng(0).uniform(0, 3e-7, x.size)
    top = np.column_stack([x.ravel(), y.ravel(), 0.04 + above])
    points = np.concatenate([top, top * [1, 1, 0]])
    assert not faces_of_corners(points).all()
    corners = corners_with_faces(points)
    assert faces_of_corners(corners).all()
    planes = ConvexHull(corners).equations
    assert (points @ planes[:, :3].T + planes[:, 3]).max() < 1e-6
    assert corners_with_faces(corners) is corners


@pytest.mark.parametrize(("size", "above", "corners"), [(0.03, 4e-6, 8), (0.1, 1.2e-5, 9), (1.0, 6e-6, 8)])
def test_corner_of_merged_faces_is_kept_only_if_high_enough(size, above, corners):
    """On a body of 1 m a corner of 6 µm would have to be raised to 0.4 mm."""
    box = size * np.array(list(product((-0.5, 0.5), (-0.5, 0.5), (-0.1, 0.1))))
    points = np.vstack([box, [0, 0, 0.1 * size + above]])
    assert not faces_of_corners(points).all()
    hull = corners_with_faces(points)
    assert len(hull) == corners
    assert faces_of_corners(hull).all()
    assert hull[:, 2].max() == pytest.approx(0.1 * size + (2 * above if corners == 9 else 0), abs=1e-12)


def test_flat_skin_without_a_link_mesh_has_a_hull():
    robot, skin = lost(covered=False)
    compile_spec(hulls_spec(robot, skin), source=robot.source)


def test_hulls_collide_in_place_of_the_shapes_of_skinned_links():
    robot = arm().robot
    skin = arm().skin
    model = compile_spec(hulls_spec(robot, skin), source=robot.source)
    solid = [int(geom) for geom in np.flatnonzero(model.geom_contype)]
    of_skinned = {model.geom(g).name for g in solid if model.body(model.geom_bodyid[g]).name in skin.links}
    assert of_skinned == {hull_name(link) for link in skin.links}
    assert {model.body(model.geom_bodyid[g]).name for g in solid} == {link.name for link in robot.links}

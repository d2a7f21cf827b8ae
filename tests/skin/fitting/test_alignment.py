"""Rigid groups of taxels are placed by the mesh of their link, or by touches at known places."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.fitting.alignment import align_to_mesh, align_to_touches, touch_centres

PITCH = 8e-3


def bowl(steps=24):
    """Return a mesh of 160 x 120 mm that bends differently along both axes."""
    x, y = np.meshgrid(np.linspace(-0.08, 0.08, steps), np.linspace(-0.06, 0.06, steps), indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), height(x, y).ravel()])
    corner = (np.arange(steps - 1)[:, None] * steps + np.arange(steps - 1)).ravel()
    lower = np.column_stack([corner, corner + steps, corner + 1])
    upper = np.column_stack([corner + 1, corner + steps, corner + steps + 1])
    return Mesh(vertices, np.vstack([lower, upper]))


def height(x, y):
    return 3.0 * x**2 + 5.0 * y**2 + 20.0 * x * x * y


def patch():
    """Return places on the bowl, 8 mm apart, and normals."""
    x, y = (one.ravel() for one in np.meshgrid(np.arange(-5, 6) * PITCH, np.arange(-4, 5) * PITCH))
    normals = np.column_stack([-6 * x - 40 * x * y, -10 * y - 20 * x * x, np.ones_like(x)])
    return np.column_stack([x, y, height(x, y)]), normals / np.linalg.norm(normals, axis=1)[:, None]


def displacement(millimetres, degrees, seed):
    """Return a displacement of the patch about its centre in random directions."""
    random = np.random.default_rng(seed)
    axis, direction = (one / np.linalg.norm(one) for one in random.normal(size=(2, 3)))
    rotation = Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix()
    centre = patch()[0].mean(axis=0)
    return Pose(rotation, centre - rotation @ centre + 1e-3 * millimetres * direction)


@pytest.mark.parametrize(("millimetres", "degrees"), [(2, 2), (5, 10)])
def test_patch_returns_to_the_mesh(millimetres, degrees):
    places, normals = patch()
    wrong = displacement(millimetres, degrees, 1).inverse
    found = align_to_mesh(bowl(), wrong.points(places), wrong.directions(normals))
    assert found.before.mean() > 5e-4
    assert found.after.mean() < 2e-4
    turned = found.pose.directions(wrong.directions(normals))
    assert np.degrees(np.arccos(np.clip((turned * normals).sum(axis=1), -1, 1))).mean() < 4
    repeated = align_to_mesh(bowl(), wrong.points(places), wrong.directions(normals))
    assert np.array_equal(repeated.pose.matrix, found.pose.matrix)


def test_group_on_a_plane_does_not_slide():
    plane = Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    places = np.column_stack([patch()[0][:, :2], np.full(99, 0.007)])
    found = align_to_mesh(plane, places, np.tile([0.0, 0.0, 1.0], (99, 1)))
    assert found.free == 3
    assert np.abs(found.pose.points(places) - places * [1, 1, 0]).max() < 1e-4
    assert np.allclose(found.before, 0.007)
    assert found.after.max() < 1e-4


def test_distant_outlier_does_not_tilt_its_patch():
    places, normals = patch()
    places[7] += 0.02 * normals[7]
    found = align_to_mesh(bowl(), places, normals)
    assert np.delete(found.after, 7).mean() < 3e-4
    assert found.after[7] > 0.015


def touches(pose, *, count=40, seed=0, outlier=False):
    """Return centres by the stated taxels, true places, and stated taxels, of touches on a misplaced patch."""
    random = np.random.default_rng(seed)
    true = patch()[0]
    stated = pose.inverse.points(true)
    xy = true[random.integers(len(true), size=count), :2] + random.uniform(-PITCH / 2, PITCH / 2, (count, 2))
    places = np.column_stack([xy, height(*xy.T)])
    away = ((true[None] - places[:, None]) ** 2).sum(axis=2)
    readings = 100 * np.exp(-away / (2 * (0.8 * PITCH) ** 2)) * random.uniform(0.9, 1.1, away.shape)
    readings += random.normal(0, 1, away.shape)
    centres, there = touch_centres(stated, readings, noise=3.0)
    assert there.all()
    if outlier:
        places[3] += [0.05, 0.0, 0.0]
    return centres, places, stated


CASES = [(1, 30), (15, 1), (6, 12)]
MORE = [(mm, deg) for mm in (1, 3, 8, 15) for deg in (1, 5, 15, 30)]


@pytest.mark.parametrize(
    ("millimetres", "degrees"), [*CASES, *(pytest.param(*case, marks=pytest.mark.long) for case in MORE)]
)
def test_touches_determine_the_misplacement_of_a_patch(millimetres, degrees):
    for seed in range(5):
        pose = displacement(millimetres, degrees, seed)
        centres, places, stated = touches(pose, seed=seed, outlier=True)
        found = align_to_touches(centres, places, stated)
        error = np.linalg.norm(found.pose.points(stated) - patch()[0], axis=1).max()
        assert error < PITCH / 5
        assert error < 4 * found.uncertainty
        assert found.uncertainty < PITCH / 5


def test_touches_that_determine_no_pose_are_rejected():
    centres, places, stated = touches(Pose.identity())
    with pytest.raises(SkinError, match="too few touches to find a pose .found: 2"):
        align_to_touches(centres[:2], places[:2], stated)
    line = np.column_stack([np.linspace(-0.04, 0.04, 20), np.zeros(20), np.zeros(20)])
    with pytest.raises(SkinError, match="on a line .found: direction -?1.00.*rotation about it is not determined"):
        align_to_touches(line, line, stated)
    with pytest.raises(SkinError, match="all touches are at one place"):
        align_to_touches(0 * line, 0 * line, stated)
    with pytest.raises(SkinError, match="needs taxels with finite positions"):
        align_to_mesh(bowl(), np.full((3, 3), np.nan))


def test_touch_without_readings_has_no_centre():
    centres, there = touch_centres(
        np.eye(3), np.array([[0.0, np.nan, 1.0], [2.0, 2.0, 0.05], [10.0, 0.0, 30.0]]), noise=1.5
    )
    assert there.tolist() == [False, True, True]
    assert np.allclose(centres[1:], [[0.5, 0.5, 0.0], [0.25, 0.0, 0.75]])

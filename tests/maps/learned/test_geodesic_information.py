"""A cloud of points flattened, and the geodesic information map that goes by way of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform

from tactile_maps.core.errors import MapError
from tactile_maps.core.progress import no_progress
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.maps.learned.geodesic_information import (
    build,
    embed_in_space,
    embed_through_space,
    flatten_point_cloud,
    locally_scaled,
    without_small_holes,
)
from tactile_maps.tactile.babbling import BabbleSpec, babble
from tests.support.surfaces import frustum, sheet, skin_of, taxels_on


def _near_stretch(cloud, points):
    """Lengths in the plane over lengths in space between points close to each other."""
    near = squareform(pdist(cloud)) + np.diag(np.full(len(cloud), np.inf))
    i, j = np.nonzero(near < 1.5 * np.median(near.min(axis=1)))
    return np.linalg.norm(points[i] - points[j], axis=1) / near[i, j]


def test_curved_sheet_is_unrolled_without_distortion():
    bent = sheet(40, 30, shape=lambda x, y: 0.02 * np.cos(x / 0.03))
    cloud = taxels_on(bent, 120).positions
    opened = flatten_point_cloud(cloud)
    assert opened.findings == ()
    assert np.ptp(_near_stretch(cloud, opened.points)) < 0.1


def test_tube_is_cut_and_unrolled():
    cloud = taxels_on(frustum(), 200).positions
    opened = flatten_point_cloud(cloud)
    assert [finding.kind for finding in opened.findings] == ["opened"]
    stretch = _near_stretch(cloud, opened.points)
    torn = stretch > 2
    assert 0 < torn.mean() < 0.15
    assert np.abs(stretch[~torn] - 1).max() < 0.15


def test_taxels_off_the_surface_are_reported_and_placed_nearby():
    cloud = taxels_on(sheet(30, 20), 100).positions.copy()
    cloud = np.concatenate([cloud, cloud[50:51] + [0.001, 0.001, 0.3]])
    opened = flatten_point_cloud(cloud)
    (note,) = [finding for finding in opened.findings if finding.kind == "taxels-beside-surface"]
    assert note.count == 1
    low = opened.points[:100].min(axis=0)
    high = opened.points[:100].max(axis=0)
    assert (low < opened.points[100]).all()
    assert (opened.points[100] < high).all()


@pytest.mark.parametrize(
    "cloud", [np.zeros((4, 3)), np.eye(3) * [1, 0, 0], np.random.default_rng(13).normal(size=(60, 3))]
)
def test_missing_surface_has_a_finding(cloud):
    with pytest.raises(MapError):
        flatten_point_cloud(cloud)


def test_small_holes_are_closed_and_large_ones_stay_open():
    surface = sheet(12, 12, width=0.12, height=0.12)
    middle = surface.vertices[surface.faces].mean(axis=1)[:, :2]
    small = np.abs(middle - [0.025, 0.025]).max(axis=1) < 0.005
    large = np.abs(middle - [0.08, 0.08]).max(axis=1) < 0.02
    faces = surface.faces[~small & ~large]
    assert sorted(len(loop) for loop in Connectivity(faces).boundary_loops) == [4, 16, 48]
    closed = without_small_holes(faces)
    assert sorted(len(loop) for loop in Connectivity(closed).boundary_loops) == [16, 48]
    assert Connectivity(closed).euler_characteristic == 0
    added = closed[len(faces) :]
    normals = np.cross(*(surface.vertices[added[:, k]] - surface.vertices[added[:, 0]] for k in (1, 2)))
    assert (normals[:, 2] != 0).all()
    assert (np.sign(normals[:, 2]) == np.sign(_up(surface, faces))).all(), "closed with the right side out"


@pytest.mark.parametrize("turn", range(10))
def test_hole_is_not_closed_across_an_existing_edge(turn):
    """Corners 0 and 2 of the hole 0-3-2-1 are joined already, whichever of its corners the fan would start from."""
    inner = [(0, 1, 2), (0, 2, 4), (2, 5, 4), (2, 3, 5), (3, 6, 5), (3, 0, 6), (0, 4, 6)]
    faces = np.array([*inner, (4, 5, 7), (5, 6, 8), (6, 4, 9)])
    faces = np.roll(faces, turn, axis=0)
    assert [len(loop) for loop in Connectivity(faces).boundary_loops] == [6, 4]
    closed = without_small_holes(faces)
    assert Connectivity(closed).face_count.max() == 2
    assert [len(loop) for loop in Connectivity(closed).boundary_loops] == [6]


def _up(surface, faces):
    a, b, c = (surface.vertices[faces[0, k]] for k in range(3))
    return np.cross(b - a, c - a)[2]


@pytest.fixture(scope="module")
def tube():
    return skin_of(frustum(0.04, 0.04, length=0.16), taxels=160)


@pytest.mark.long
def test_taxels_of_a_sheet_are_learned_at_their_positions(touched_sheet, misfit):
    learned = build(touched_sheet[1])
    assert learned.method == "geodesic-information"
    assert "no-learned-surface" not in [finding.kind for finding in learned.findings]
    assert misfit(learned.points) < 0.5


def test_distances_are_scaled_by_the_neighbourhoods_of_both_ends():
    unlike = np.array([[0.0, 2, 4], [2, 0, np.inf], [4, np.inf, 0]])
    scaled = locally_scaled(unlike, neighbours=2)
    # Near is 4 for the first and third, and for the second, which knows one neighbour only, 2.
    assert np.allclose(scaled, [[0, 2 / np.sqrt(8), 1], [2 / np.sqrt(8), 0, np.inf], [1, np.inf, 0]])


def test_local_scaling_does_not_depend_on_density():
    unlike = np.array([[0.0, 1, 2], [1, 0, 2], [2, 2, 0]])
    assert np.allclose(locally_scaled(unlike), locally_scaled(5 * unlike))


def test_points_in_space_are_recovered():
    truth = np.random.default_rng(12).normal(size=(30, 3))
    assert np.allclose(pdist(embed_in_space(squareform(pdist(truth)))), pdist(truth), atol=1e-6)


@pytest.mark.long
def test_tube_is_opened_along_a_cut(tube):
    learned = build(babble(tube, BabbleSpec(touches=2000)))
    assert "opened" in [finding.kind for finding in learned.findings]
    near = squareform(pdist(learned.points)) + np.diag(np.full(160, np.inf))
    truth = squareform(pdist(tube.patches[0].taxels.positions)) + np.diag(np.full(160, np.inf))
    kept = [len(np.intersect1d(a[:6], b[:6])) for a, b in zip(near.argsort(1), truth.argsort(1), strict=True)]
    assert np.mean(kept) > 0.75 * 6, "crushed into the plane it keeps half"


def test_taxels_without_a_surface_are_embedded_directly_in_the_plane():
    line = squareform(pdist(np.arange(12.0)[:, None]))
    points, (note,) = embed_through_space(line, no_progress)
    assert note.kind == "no-learned-surface"
    assert np.allclose(pdist(points), pdist(np.arange(12.0)[:, None]), atol=1e-6)

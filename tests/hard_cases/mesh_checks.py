"""Checks of the map of any mesh, as functions for a child process."""

from __future__ import annotations

import numpy as np

from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.mesh_skin import skin_of_mesh
from tactile_maps.skin.model.skin import Skin
from tactile_maps.skin.taxel_placement.placement import PlacementSpec
from tests.hard_cases.meshes import hard_mesh

TAXELS = 40


def check_named(name: str, surface: str = "all") -> None:
    """The laws for one mesh of the catalogue."""
    mesh = hard_mesh(name)
    check_map(
        build_map(check_skin(skin_of_mesh(mesh, PlacementSpec(taxels=TAXELS), name=name, surface=surface), TAXELS))
    )


def check_skin(skin: Skin, taxels: int) -> Skin:
    assert len(skin) == taxels
    for patch in skin.patches:
        felt = patch.taxels.areas.sum()
        assert abs(felt - patch.surface.area) <= 1e-9 * felt
        assert (patch.taxels.areas > 0).all()
        assert np.isfinite(patch.taxels.normals).all()
    return skin


def check_map(map_: TactileMap) -> None:
    """Finite, no face flipped, no border crossing itself or another, and back from the map the same point."""
    check_one_to_one(map_)
    check_round_trip(map_)
    weights = TactileImage(map_, width=48).weights
    assert np.isfinite(weights.data).all()


def check_one_to_one(map_: TactileMap) -> None:
    borders = []
    for plane, chart in zip(map_.uv, map_.charts, strict=True):
        assert np.isfinite(plane).all()
        assert not flipped(plane, chart.faces).any()
        (loop,) = chart.connectivity.boundary_loops
        borders.append(plane[loop])
    assert crossings(*borders) == 0
    assert np.isfinite([chart.energies[-1] for chart in map_.charts]).all()


def check_round_trip(map_: TactileMap, count: int = 300) -> None:
    rng = np.random.default_rng(0)
    for number, patch in enumerate(map_.skin.patches):
        surface = patch.surface
        faces = rng.integers(len(surface.faces), size=count)
        weights = rng.dirichlet([1, 1, 1], count)
        patches, back, there = map_.to_body_many(map_.to_map_many(np.full(count, number), faces, weights))
        assert (patches == number).all()
        away = np.linalg.norm(surface.points(back, there) - surface.points(faces, weights), axis=1)
        assert away.max() < 1e-9 * surface.size + rounding(surface)


def rounding(surface: Mesh) -> float:
    """Few last digits of the coordinates, which far from the origin are all there is [m]."""
    return 8 * float(np.spacing(np.abs(surface.vertices).max()))


def energy(mesh: Mesh) -> float:
    """Distortion of the best map, mean over the pieces by area."""
    map_ = build_map(skin_of_mesh(mesh, PlacementSpec(taxels=TAXELS), surface="all"))
    areas = [patch.surface.area for patch in map_.skin.patches]
    return float(np.average([chart.energies[-1] for chart in map_.charts], weights=areas))

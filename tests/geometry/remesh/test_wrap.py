from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.remesh import wrap as wrap_module
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tests.hard_cases.meshes import HARD_MESHES

SPHERE = HARD_MESHES["sphere"]


def test_wrap_of_a_ball_is_a_larger_ball() -> None:
    surface = wrap_mesh(SPHERE, thickness=0.01, voxel=0.01).surface
    radius = np.linalg.norm(surface.vertices, axis=1)
    assert radius == pytest.approx(0.11, abs=1e-3)
    assert surface.area == pytest.approx(4 * np.pi * 0.11**2, rel=0.02)


def test_triangles_are_well_shaped() -> None:
    surface = wrap_mesh(HARD_MESHES["cube"], thickness=0.01, voxel=0.01, closing=0.03).surface
    corners = surface.vertices[surface.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    assert np.percentile(2 * surface.face_areas / longest**2, 1) > 0.3  # height over longest side


@pytest.mark.parametrize(
    ("name", "closing"),
    [
        ("two components", 0.012),
        *(
            pytest.param(name, closing, marks=pytest.mark.long)
            for name, closing in (
                ("two components", 0.0),
                ("cube", 0.012),
                ("cube", 0.0),
                ("torus", 0.012),
                ("torus", 0.0),
            )
        ),
    ],
)
def test_exact_distance_is_computed_at_few_nodes_without_effect_on_the_surface(
    monkeypatch: pytest.MonkeyPatch, name: str, closing: float
) -> None:
    mesh = HARD_MESHES[name]
    asked: list[int] = []

    def ask(points: FloatArray, exact: Callable[[FloatArray], FloatArray]) -> FloatArray:
        asked[-1] += len(points)
        return exact(points)

    def exact_here(level: float, lowest: FloatArray, highest: FloatArray, grid: Any, exact: Any) -> FloatArray:
        asked.append(0)
        return thrifty(level, lowest, highest, grid, lambda points: ask(points, exact))

    def exact_everywhere(level: float, lowest: FloatArray, highest: FloatArray, grid: Any, exact: Any) -> FloatArray:
        return np.where(highest > lowest, exact(grid.nodes), highest)

    thrifty = wrap_module._exact_at
    monkeypatch.setattr(wrap_module, "_exact_at", exact_here)
    quick = wrap_mesh(mesh, thickness=0.006, voxel=0.009, closing=closing)
    monkeypatch.setattr(wrap_module, "_exact_at", exact_everywhere)
    slow = wrap_mesh(mesh, thickness=0.006, voxel=0.009, closing=closing)
    assert max(asked) < 8 * len(quick.surface.vertices)
    assert quick.findings == slow.findings
    assert np.array_equal(quick.surface.faces, slow.surface.faces)
    assert np.array_equal(quick.surface.vertices, slow.surface.vertices)


@pytest.mark.long
def test_closing_fills_a_hole_and_removes_the_handle() -> None:
    torus = HARD_MESHES["torus"]
    open_ = wrap_mesh(torus, thickness=0.003, voxel=0.006).surface
    spanned = wrap_mesh(torus, thickness=0.003, voxel=0.006, closing=0.12).surface
    assert open_.connectivity.euler_characteristic == 0
    assert spanned.connectivity.euler_characteristic == 2


def test_too_large_grid_is_made_coarser_and_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wrap_module, "MAX_NODES", 20_000)
    result = wrap_mesh(SPHERE, thickness=0.002, voxel=0.002, where="ball")
    assert [f.kind for f in result.findings] == ["coarse-wrap"]
    assert result.voxel > 0.002
    distances = np.linalg.norm(result.surface.vertices, axis=1) - np.linalg.norm(SPHERE.vertices, axis=1).max()
    assert np.median(distances) > 2 * 0.002, "the cover is as thick as the grid can resolve"


@pytest.mark.long
@pytest.mark.parametrize("voxel", [0.012, 0.02, 0.028])
def test_loose_part_omitted_before_gap_filling_is_not_restored(voxel: float) -> None:
    """Grown by the ball that rolls over them, what is left of it would enclose more than the part that is kept."""
    result = wrap_mesh(HARD_MESHES["two components"], thickness=0.0154, voxel=voxel, closing=0.0463)
    assert np.linalg.norm(result.surface.vertices, axis=1) == pytest.approx(0.1154, abs=0.004)
    assert [(f.kind, f.count) for f in result.findings] == [("loose-part", 1)]


def test_loose_parts_are_reported() -> None:
    result = wrap_mesh(HARD_MESHES["two components"], thickness=0.005, voxel=0.008)
    assert [(f.kind, f.count) for f in result.findings] == [("loose-part", 1)]


@pytest.mark.parametrize("sizes", [(0, 1, 0), (1, 0, 0), (1, 1, -1), (np.nan, 1, 0), (1, np.inf, 0)])
def test_invalid_sizes_are_rejected(sizes: tuple[float, float, float]) -> None:
    with pytest.raises(MeshError, match="positive"):
        wrap_mesh(SPHERE, thickness=sizes[0], voxel=sizes[1], closing=sizes[2])

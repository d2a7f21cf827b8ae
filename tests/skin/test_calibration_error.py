"""A skin with a wrong assumed position: the same taxels and triangles, displaced."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.calibration_error import (
    MAX_ERROR,
    MODULE_TAXELS,
    group_into_modules,
    with_area_error,
    with_calibration_error,
    with_sleeve_displaced,
)
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import taxels_at_barycentric
from tests.support.touch import bar_skin

SKIN = bar_skin(300)


def shifts(believed, skin=SKIN):
    return believed.patches[0].taxels.positions - skin.patches[0].taxels.positions


@pytest.mark.long
@pytest.mark.parametrize("by", ["taxel", "module"])
def test_each_axis_has_the_requested_error(by):
    found = np.concatenate([shifts(with_calibration_error(SKIN, 0.002, seed=seed, by=by)) for seed in range(8)])
    assert found.std(axis=0) == pytest.approx([0.002] * 3, rel=0.2)
    assert np.abs(found.mean(axis=0)).max() < 0.0006


def test_taxels_are_displaced_independently_and_modules_rigidly():
    patch = SKIN.patches[0].taxels
    alone, together = (shifts(with_calibration_error(SKIN, 0.002, by=by)) for by in ("taxel", "module"))
    groups = group_into_modules(patch.positions)
    assert len(groups) == pytest.approx(len(SKIN) / MODULE_TAXELS, abs=1)

    def own(moved):
        """Mean square of how pairs within a module change their distance."""
        changes = []
        for group in groups:
            before = patch.positions[group]
            after = patch.positions[group] + moved[group]
            sides = [np.linalg.norm(x[:, None] - x[None], axis=2) for x in (before, after)]
            changes.append(np.abs(sides[1] - sides[0]).max())
        return float(np.mean(changes))

    assert own(alone) > 0.002
    assert own(together) < 1e-9, "rigid"


def test_calibration_error_keeps_faces_and_areas():
    believed = with_calibration_error(SKIN, 0.003)
    true = SKIN.patches[0]
    said = believed.patches[0]
    assert np.array_equal(said.surface.faces, true.surface.faces)
    for name in ("faces", "weights", "areas", "neighbours"):
        assert np.array_equal(getattr(said.taxels, name), getattr(true.taxels, name)), name
    assert np.array_equal(said.taxels.quadrature.areas, true.taxels.quadrature.areas)
    assert np.allclose(said.surface.points(said.taxels.faces, said.taxels.weights), said.taxels.positions)
    assert np.allclose(np.linalg.norm(said.taxels.normals, axis=1), 1)
    assert [finding.kind for finding in believed.findings] == ["misplaced"]


def test_surface_between_taxels_is_displaced_with_them():
    """Halfway between two neighbours it moves by the mean of both."""
    fine = bar_skin(60, finer=3)
    said = with_calibration_error(fine, 0.001).patches[0].surface
    patch = fine.patches[0]
    moved = shifts(with_calibration_error(fine, 0.001), fine)
    vertices = said.vertices - patch.surface.vertices
    errors = []
    sizes = []
    for i, j in patch.taxels.neighbours:
        middle = patch.taxels.positions[[i, j]].mean(axis=0)
        nearest = int(np.linalg.norm(patch.surface.vertices - middle, axis=1).argmin())
        errors.append(np.linalg.norm(vertices[nearest] - moved[[i, j]].mean(axis=0)))
        sizes.append(np.linalg.norm(moved[[i, j]].mean(axis=0)))
    assert np.median(errors) < 0.3 * np.median(sizes)


@pytest.mark.long
def test_error_of_a_seed_scales_with_its_size():
    assert np.array_equal(
        shifts(with_calibration_error(SKIN, 0.002, seed=3)), shifts(with_calibration_error(SKIN, 0.002, seed=3))
    )
    assert not np.allclose(
        shifts(with_calibration_error(SKIN, 0.002, seed=4)), shifts(with_calibration_error(SKIN, 0.002, seed=3))
    )
    assert np.allclose(
        shifts(with_calibration_error(SKIN, 0.004, seed=3)),
        2 * shifts(with_calibration_error(SKIN, 0.002, seed=3)),
        atol=1e-9,
    )
    assert with_calibration_error(SKIN, 0.0) is SKIN


@pytest.mark.parametrize("by", ["taxel", "module"])
@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_taxels_or_one_can_be_misplaced(by, count):
    """Too few for a surface of their own: each part of the skin goes with the taxel that is nearest."""
    surface = SKIN.patches[0].surface
    faces = np.arange(count) * 20
    owner = np.full(len(surface.faces), -1)
    owner[faces] = np.arange(count)
    lone = Skin(
        (Patch("top", "bar", surface, taxels_at_barycentric(surface, faces, np.full((count, 3), 1 / 3), owner)),)
    )
    moved = shifts(with_calibration_error(lone, 0.002, by=by), lone)
    assert (np.linalg.norm(moved, axis=1) > 1e-5).all()


@pytest.mark.parametrize("sd", [-0.001, float("nan"), float("inf"), 2 * MAX_ERROR])
def test_invalid_errors_are_rejected(sd):
    with pytest.raises(SkinError, match="calibration error is out of range"):
        with_calibration_error(SKIN, sd)


def test_unknown_units_are_rejected():
    with pytest.raises(SkinError, match="unknown unit") as caught:
        with_calibration_error(SKIN, 0.001, by="link")
    assert "taxel or module" in str(caught.value)


def test_sleeve_is_displaced_rigidly():
    believed = with_sleeve_displaced(SKIN, shift=0.005, turn=0.3)
    for patch, moved in zip(SKIN.patches, believed.patches, strict=True):
        places = patch.taxels.positions
        axis = np.linalg.svd(places - places.mean(axis=0), full_matrices=False)[2][0]
        away = moved.taxels.positions - places
        assert away @ axis == pytest.approx(np.full(len(away), away[0] @ axis)), "as far along for all"
        assert abs(away[0] @ axis) == pytest.approx(0.005)
        angles = np.arccos(np.clip(np.einsum("nd,nd->n", moved.taxels.normals, patch.taxels.normals), -1, 1))
        assert angles.max() <= 0.3 + 1e-9
        assert np.array_equal(moved.surface.faces, patch.surface.faces)
    assert with_sleeve_displaced(SKIN).patches[0].taxels.positions == pytest.approx(SKIN.patches[0].taxels.positions)


@pytest.mark.parametrize("wrong", [{"shift": 0.2}, {"shift": float("nan")}, {"turn": float("inf")}])
def test_invalid_displacements_are_rejected(wrong):
    with pytest.raises(SkinError, match="displaced"):
        with_sleeve_displaced(SKIN, **wrong)


def test_gain_error_scales_every_area():
    believed = with_area_error(SKIN, 0.8)
    for patch, wrong in zip(SKIN.patches, believed.patches, strict=True):
        assert wrong.taxels.areas == pytest.approx(0.8 * patch.taxels.areas)
    with pytest.raises(SkinError, match="gain"):
        with_area_error(SKIN, 0.0)

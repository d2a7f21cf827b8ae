"""Axes of taxels and the tangents of their frames: checks, selection and joined skins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.calibration_error import with_calibration_error, with_sleeve_displaced
from tactile_maps.skin.model.skin import Skin, merge_skins
from tactile_maps.skin.model.skin_file import skin_from_bytes, skin_to_bytes
from tactile_maps.skin.model.taxel_axes import tangents_on
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import reconstruct_skin
from tests.support.surfaces import frustum, sheet, skin_of


def tangents_of(taxels):
    """Return unit tangents, the same direction for all."""
    return tangents_on(np.tile([0.6, 0.8, 0.0], (len(taxels), 1)), taxels.normals)


def three_axis(skin: Skin) -> Skin:
    """Return the skin with three axes and stated tangents on its last patch."""
    *others, last = skin.patches
    taxels = replace(last.taxels, axes=np.full(len(last.taxels), 3), tangents=tangents_of(last.taxels))
    return Skin((*others, replace(last, taxels=taxels)))


def grid(axes=None, tangents=None, *, normals=True) -> TaxelSet:
    places = np.stack(np.meshgrid(*2 * [0.01 * np.arange(4)], indexing="ij"), axis=-1).reshape(-1, 2)
    positions = np.column_stack([places, np.zeros(16)])
    up = np.tile([0.0, 0.0, 1.0], (16, 1)) if normals else None
    return TaxelSet("grid", "hand", np.arange(16), positions, up, axes=axes, tangents=tangents)


def test_skin_without_axes_has_one_axis_and_no_tangents():
    skin = skin_of(sheet(4, 4), taxels=5)
    assert skin.axes.tolist() == [1] * 5
    assert not skin.three_axis.any()
    assert np.isnan(skin.tangents).all()


def test_mixed_skin_states_axes_and_tangents_of_each_taxel():
    skin = three_axis(skin_of(sheet(4, 4), frustum(), taxels=6))
    assert skin.axes.tolist() == [1] * 6 + [3] * 6
    assert skin.three_axis.tolist() == [False] * 6 + [True] * 6
    assert np.isnan(skin.tangents[:6]).all()
    np.testing.assert_array_equal(skin.tangents[6:], skin.patches[1].taxels.tangents)
    again = merge_skins([skin, skin])
    assert again.axes.tolist() == 2 * skin.axes.tolist()
    np.testing.assert_array_equal(again.tangents, np.tile(skin.tangents, (2, 1)))


def test_axes_that_are_all_one_and_tangents_that_are_all_missing_are_dropped():
    taxels = skin_of(sheet(4, 4), taxels=5).patches[0].taxels
    same = replace(taxels, axes=np.ones(5), tangents=np.full((5, 3), np.nan))
    assert (same.axes, same.tangents) == (None, None)


def _with(row, value):
    tangents = np.tile([1.0, 0.0, 0.0], (5, 1))
    tangents[row] = value
    return tangents


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"axes": [1, 3, 2, 3, 1]}, "axes, row 2: invalid number of axes .found: 2.*Choose 1"),
        ({"axes": [3, 3]}, "axes: the number of rows"),
        ({"tangents": np.ones((4, 3))}, "tangents: the number of rows"),
        ({"tangents": _with(3, [0.0, 0.0, 1.0])}, "tangents, row 3: a tangent is not perpendicular to the normal"),
        ({"tangents": _with(1, [0.5, 0.0, 0.0])}, "tangents, row 1: a tangent is not of length one"),
        ({"tangents": _with(4, [1.0, np.nan, 0.0])}, "tangents, row 4: a tangent is not a finite number"),
        ({"tangents": _with(0, [np.inf, 0.0, 0.0])}, "tangents, row 0: a tangent is not a finite number"),
    ],
)
def test_invalid_axes_name_the_row_and_the_remedy(changes, problem):
    changes = {key: np.asarray(value) for key, value in changes.items()}
    with pytest.raises(SkinError, match=problem):
        replace(skin_of(sheet(4, 4), taxels=5).patches[0].taxels, **changes)
    with pytest.raises(SkinError, match=problem):
        replace(grid().select(np.arange(16) < 5), **changes)


def test_tangents_of_taxels_without_normals_need_only_have_length_one():
    tilted = np.tile([0.6, 0.0, 0.8], (16, 1))
    assert grid(tangents=tilted, normals=False).tangents is not None
    with pytest.raises(SkinError, match="perpendicular"):
        grid(tangents=tilted)


def test_tangents_are_projected_along_other_normals():
    normals = np.array([[0.0, 0.6, 0.8], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    found = tangents_on(np.tile([1.0, 0.0, 0.0], (3, 1)), normals)
    np.testing.assert_allclose(found[:2], [[1, 0, 0], [1, 0, 0]], atol=1e-15)
    assert np.isnan(found[2]).all()


def test_selected_taxels_keep_their_axes():
    axes = np.where(np.arange(16) % 2, 3, 1)
    tangents = np.tile([0.6, 0.8, 0.0], (16, 1))
    tangents[::2] = np.nan
    chosen = grid(axes, tangents).select(np.arange(16) >= 13)
    assert chosen.axes.tolist() == [3, 1, 3]
    np.testing.assert_array_equal(chosen.tangents, tangents[13:])


def test_reconstruction_keeps_axes_and_projects_tangents_onto_the_surface():
    axes = np.where(np.arange(16) % 3, 3, 1)
    found = reconstruct_skin(grid(axes, np.tile([0.6, 0.0, 0.8], (16, 1)), normals=False))
    np.testing.assert_array_equal(found.skin.axes[found.taxel_of], axes)
    np.testing.assert_allclose(found.skin.tangents, np.tile([1.0, 0.0, 0.0], (16, 1)), atol=1e-12)


def test_skin_file_keeps_axes_and_tangents():
    skin = three_axis(skin_of(sheet(4, 4), frustum(), taxels=6))
    back = skin_from_bytes(skin_to_bytes(skin))
    np.testing.assert_array_equal(back.axes, skin.axes)
    np.testing.assert_array_equal(back.tangents, skin.tangents)
    assert back.patches[0].taxels.axes is None
    assert skin_to_bytes(back) == skin_to_bytes(skin)


@pytest.mark.parametrize("by", ["taxel", "module"])
def test_tangents_of_a_misplaced_skin_are_perpendicular_to_its_normals(by):
    skin = three_axis(skin_of(frustum(), taxels=40))
    taxels = with_calibration_error(skin, 0.002, by=by).patches[0].taxels
    assert taxels.axes.tolist() == [3] * 40
    np.testing.assert_allclose(np.einsum("ij,ij->i", taxels.tangents, taxels.normals), 0, atol=1e-12)


def test_frames_of_one_misplaced_module_rotate_rigidly_with_its_taxels():
    skin = three_axis(skin_of(sheet(4, 4), taxels=8))
    true = skin.patches[0].taxels
    moved = with_calibration_error(skin, 0.002, by="module").patches[0].taxels
    before = true.positions - true.positions.mean(axis=0)
    after = moved.positions - moved.positions.mean(axis=0)
    along = true.tangents[0] @ np.linalg.pinv(before) @ after  # material direction of the flat module
    assert np.linalg.norm(along - true.tangents[0]) > 0.01
    np.testing.assert_allclose(moved.tangents, tangents_on(np.tile(along, (8, 1)), moved.normals), atol=1e-9)


def test_tangents_of_a_displaced_sleeve_rotate_with_it():
    skin = three_axis(skin_of(frustum(), taxels=40))
    true = skin.patches[0].taxels
    moved = with_sleeve_displaced(skin, turn=0.5).patches[0].taxels
    before = np.stack([true.tangents, true.normals, np.cross(true.normals, true.tangents)], axis=1)
    after = np.stack([moved.tangents, moved.normals, np.cross(moved.normals, moved.tangents)], axis=1)
    turns = np.swapaxes(before, 1, 2) @ after
    np.testing.assert_allclose(turns, np.broadcast_to(turns[0], turns.shape), atol=1e-9)
    assert np.trace(turns[0]) == pytest.approx(1 + 2 * np.cos(0.5))

"""Arranging can be undone and mixed; snapping meets what is near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import (
    EDGES,
    align,
    mirror,
    move,
    repack,
    rotate,
    scale,
    snap_move,
    true_size,
)
from tactile_maps.editing.document import show_patches
from tactile_maps.flattening.bijectivity import signed_areas
from tactile_maps.maps.evaluation.distortion import distortion
from tactile_maps.maps.evaluation.quality import overlaps
from tactile_maps.maps.model.layout import MapLayout, Placement


def _middle(document, numbers):
    boxes = document.map.boxes[list(numbers)]
    return 0.5 * (boxes[:, 0].min(axis=0) + boxes[:, 1].max(axis=0))


def _same(first, second, **kwargs):
    for a, b in zip(first.map.uv, second.map.uv, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12, **kwargs)


def test_move_applies_to_the_chosen_patches(document):
    moved = move(document, [0, 2], (0.1, -0.2))
    for number, step in ((0, (0.1, -0.2)), (1, (0, 0)), (2, (0.1, -0.2))):
        np.testing.assert_allclose(moved.map.uv[number], document.map.uv[number] + step, atol=1e-15)


def test_edit_without_change_returns_the_same_document(document):
    assert move(document, [1], (0.0, 0.0)) is document
    assert move(document, [], (1.0, 0.0)) is document
    assert rotate(document, [], 1.0) is document
    assert scale(document, [1], 1.0) is document
    assert true_size(document, [0, 1, 2]) is document


def test_rotation_is_counter_clockwise_about_the_common_centre(document):
    turned = rotate(document, [0, 1], np.pi / 2)
    offset = document.map.uv[0] - _middle(document, [0, 1])
    expected = _middle(document, [0, 1]) + offset @ np.array([[0, 1], [-1, 0]])
    np.testing.assert_allclose(turned.map.uv[0], expected, atol=1e-12)


def test_rotation_about_a_point_keeps_the_point(document):
    about = document.map.uv[1][5]
    np.testing.assert_allclose(rotate(document, [1], 1.3, about=about).map.uv[1][5], about, atol=1e-15)


def test_rotations_add_up_modulo_a_full_turn(document):
    turned = document
    for _ in range(24):
        turned = rotate(turned, [0], np.radians(15), about=np.zeros(2))
    _same(turned, document)
    assert abs(turned.layout.placements[0].angle) < 1e-12


def test_mirroring_once_flips_faces_and_twice_restores_them(document):
    once = mirror(rotate(document, [1], 0.4), [1])
    assert once.layout.placements[1].mirrored
    assert (signed_areas(once.map.uv[1], once.charts[1].faces) < 0).all()
    _same(mirror(mirror(document, [1]), [1]), document)
    np.testing.assert_allclose(_middle(once, [1]), _middle(rotate(document, [1], 0.4), [1]), atol=1e-12)


def test_scaling_changes_placements_and_is_undone_exactly(document):
    large = scale(document, [2], 3.0)
    np.testing.assert_allclose(np.ptp(large.map.uv[2], axis=0), 3 * np.ptp(document.map.uv[2], axis=0))
    count = len(document.charts[2].faces)
    np.testing.assert_allclose(distortion(large.map).area[-count:], 9 * distortion(document.map).area[-count:])
    small = true_size(scale(large, [2], 1 / 7), [2])
    assert small.layout.placements[2].scale == 1.0
    _same(small, document)


@pytest.mark.parametrize("factor", [0.0, -1.0, 0.01, 11.0, np.nan, np.inf])
def test_implausible_scale_is_rejected(document, factor):
    with pytest.raises(MapError, match=r"too small or too large|not finite"):
        scale(document, [0], factor)


@pytest.mark.parametrize("by", [(1e7, 0.0), (0.0, np.nan), (np.inf, 0.0)])
def test_implausible_move_is_rejected(document, by):
    with pytest.raises(MapError, match=r"too far from the origin|not finite"):
        move(document, [0], by)


@pytest.mark.parametrize("edge", EDGES)
def test_aligned_patches_share_an_edge_and_keep_the_other_coordinate(document, edge):
    boxes = align(document, [0, 1, 2], edge).map.boxes
    k = 0 if edge in ("left", "centre", "right") else 1
    line = {"left": boxes[:, 0], "bottom": boxes[:, 0], "right": boxes[:, 1], "top": boxes[:, 1]}
    np.testing.assert_allclose(np.ptp(line.get(edge, boxes.mean(axis=1))[:, k]), 0, atol=1e-12)
    np.testing.assert_allclose(boxes[:, :, 1 - k], document.map.boxes[:, :, 1 - k], atol=1e-15)


def test_one_patch_cannot_be_aligned(document):
    with pytest.raises(MapError, match="aligning needs two patches"):
        align(document, [1], "left")


def _heap(document):
    """All patches on one another, one turned, one mirrored and one enlarged."""
    placements = (Placement(0.5), Placement(mirrored=True), Placement(scale=2.0))
    return document.with_layout(MapLayout(placements))


def test_repacking_all_separates_patches_and_keeps_their_rotation_and_scale(document):
    heap = _heap(document)
    assert overlaps(heap.map) > 0
    packed = repack(heap)
    assert overlaps(packed.map) == 0
    for old, new in zip(heap.layout.placements, packed.layout.placements, strict=True):
        assert replace(new, offset=old.offset) == old


def test_repacking_a_packed_map_gives_the_same_layout(document):
    assert repack(document) is document
    _same(repack(move(document, [1], (0.7, 0.2))), document)


def test_repacking_chosen_patches_moves_them_to_the_nearest_free_place(document):
    onto = _middle(document, [1]) - _middle(document, [0])
    heap = move(document, [0], onto)
    assert overlaps(heap.map) > 0
    packed = repack(heap, [0])
    assert overlaps(packed.map) == 0
    assert packed.layout.placements[1:] == document.layout.placements[1:]
    assert np.linalg.norm(_middle(packed, [0]) - _middle(heap, [0])) < np.ptp(document.map.bounds, axis=0).max()


def test_repacking_a_patch_without_overlap_keeps_it_in_place(document):
    away = move(document, [2], (5.0, 5.0))
    assert repack(away, [2]) is away


def test_repacking_without_patches_has_no_effect(document):
    assert repack(document, []) is document


def _near(document, gap):
    """A move of patch 1 that brings its left side to ``gap`` right of patch 0's right side."""
    boxes = document.map.boxes
    return np.array([boxes[0, 1, 0] - boxes[1, 0, 0] + gap, 1.0])


def test_side_snaps_to_a_side_and_reports_the_guide(document):
    snap = snap_move(document, [1], _near(document, 0.001), reach=0.002)
    moved = move(document, [1], snap.by)
    assert moved.map.boxes[1, 0, 0] == pytest.approx(document.map.boxes[0, 1, 0], abs=1e-12)
    assert snap.x == (pytest.approx(document.map.boxes[0, 1, 0]),)
    assert (snap.by[1], snap.y) == (1.0, ()), "one coordinate snaps without the other"


def test_distant_edges_do_not_snap(document):
    by = _near(document, 0.001)
    assert snap_move(document, [1], by, reach=0.0).by == tuple(by)
    assert snap_move(document, [1], (3.0, 3.0), reach=0.002).by == (3.0, 3.0)


def test_hidden_and_moving_patches_do_not_attract(document):
    by = _near(document, 0.0001)
    only = show_patches(document, [0, 2], visible=False)
    assert snap_move(only, [1], by, reach=0.002).by == tuple(by)
    assert snap_move(document, [0, 1, 2], by, reach=0.002).by == tuple(by)
    assert snap_move(document, [], by, reach=0.002).by == tuple(by)

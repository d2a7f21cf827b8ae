"""Flips and overlaps of a whole map are found where they lie; nothing is found on a good one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.editing.document import MapDocument
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.distortion import distortion
from tactile_maps.maps.evaluation.quality import measure
from tactile_widgets.views.map.items.bijectivity import FlawFinder
from tests.support.surfaces import frustum, named, skin_of


@pytest.fixture(scope="module")
def three_patches():
    return build_map(skin_of(frustum(along=16, around=30), named("saddle"), named("hemisphere")))


def pulled_over(map_):
    """The same map with one inner point of the second patch pulled across its chart."""
    plane = map_.charts[1].plane.copy()
    inner = np.linalg.norm(plane - plane.mean(axis=0), axis=1).argmin()
    plane[inner] += [0.012, 0.0]
    first, second, *others = map_.charts
    return replace(map_, charts=(first, replace(second, plane=plane), *others))


def test_a_good_map_has_no_flaws(three_patches):
    found = FlawFinder().of(MapDocument.of(three_patches))
    assert found.flips.shape == (0, 3, 2)
    assert found.overlaps.shape == (0, 2)


def test_every_flip_is_found_where_it_lies_on_the_placed_map(three_patches):
    map_ = pulled_over(three_patches)
    chart = map_.charts[1]
    uv = map_.uv[1]
    moved = int(np.abs(chart.plane - three_patches.charts[1].plane).sum(axis=1).argmax())
    found = FlawFinder().of(MapDocument.of(map_))
    assert len(found.flips) >= 1
    assert (np.linalg.norm(found.flips - uv[moved], axis=2).min(axis=1) < 1e-12).all(), "each has the point that moved"
    assert len(found.flips) == distortion(map_).flipped.sum()
    assert not len(found.overlaps)


def test_a_mirrored_patch_is_not_flipped(three_patches):
    layout = three_patches.layout
    first = replace(layout.placements[0], mirrored=True)
    mirrored = replace(three_patches, layout=replace(layout, placements=(first, *layout.placements[1:])))
    assert not len(FlawFinder().of(MapDocument.of(mirrored)).flips)


def moved_onto_the_first(map_, aside):
    """The second patch moved over the first, so far aside [m]."""
    first, second, *others = map_.layout.placements
    onto = replace(second, offset=tuple(np.add(first.offset, aside)))
    return replace(map_, layout=replace(map_.layout, placements=(first, onto, *others)))


def test_overlapping_patches_are_marked_where_their_borders_meet(three_patches):
    map_ = moved_onto_the_first(three_patches, [0.0, 0.0])
    found = FlawFinder().of(MapDocument.of(map_))
    assert len(found.overlaps) == measure(map_).overlaps >= 2
    assert not len(found.flips)
    for border in map_.outlines[:2]:
        longest = np.linalg.norm(np.diff(border, axis=0), axis=1).max()
        away = np.linalg.norm(found.overlaps[:, None] - border, axis=2).min(axis=1)
        assert (away < 2 * longest).sum() >= 2


def test_a_patch_within_another_is_marked_though_no_borders_meet(three_patches):
    map_ = moved_onto_the_first(three_patches, [0.03, 0.01])
    found = FlawFinder().of(MapDocument.of(map_)).overlaps
    assert len(found) == measure(map_).overlaps == 1
    low = map_.uv[1].min(axis=0)
    high = map_.uv[1].max(axis=0)
    assert ((found > low) & (found < high)).all()

"""Modules: stiff, side by side, not over an edge, and on a plane as close as tiles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.distance import pdist

from app.errors import SkinError
from app.geometry.subdivide import subdivide
from app.skin.placing.modules import MARGIN, PADS, SIDE, place_modules
from tests.numerics.map_surfaces import cap, frustum, sheet

PITCH = 0.0065


def _placed(surface, **more):
    surface = subdivide(surface, longest=PITCH / 2.5).mesh
    allowed = more.get("allowed", lambda centres: np.ones(len(centres), bool))(surface.vertices[surface.faces].mean(1))
    return surface, place_modules(surface, PITCH, allowed=allowed, seed=more.get("seed", 0))


def test_the_pattern_is_icubs():
    """The pads of iCubSkinGui's ``triangle_10pad``, in its units of about a fortieth of a millimetre."""
    x = np.array([257.2, 385.83, 128.62, 0, -128.62, -385.83, -257.2, -128.62, 0, 128.62])
    y = np.array([0, -222.83, -222.83, 0, -222.83, -222.83, 0, 222.83, 445.54, 222.83])
    assert np.abs(257.24 * PADS - np.stack([x, y], axis=1)).max() < 0.3
    assert sorted(pdist(PADS))[:18] == pytest.approx([1.0] * 18)


def test_on_a_plane_modules_keep_their_shape_and_do_not_overlap():
    surface, taxels = _placed(sheet(width=0.3, height=0.2))
    modules = taxels.positions.reshape(-1, 10, 3)
    tiles = surface.area / (np.sqrt(3) / 4 * (SIDE * PITCH) ** 2)
    assert 0.7 * tiles < len(modules) <= tiles
    for module in modules:
        assert pdist(module) == pytest.approx(PITCH * pdist(PADS), abs=1e-9)
    apart = 2 * MARGIN * PITCH
    for k, module in enumerate(modules):
        hull = ConvexHull(module[:, :2]).equations
        others = np.delete(modules, k, axis=0).reshape(-1, 3)[:, :2]
        assert (others @ hull[:, :2].T + hull[:, 2]).max(axis=1).min() > 0.9 * apart
    assert (taxels.positions[:, :2] > 0.4 * MARGIN * PITCH).all()


@pytest.mark.parametrize("surface", [frustum(around=72, length=0.15), cap(1.2, radius=0.1)], ids=["tube", "cap"])
def test_on_a_bent_surface_pads_stay_apart_and_three_quarters_are_covered(surface):
    surface, taxels = _placed(surface)
    away = cKDTree(taxels.positions).query(taxels.positions, k=2)[0][:, 1]
    assert away.min() > 0.7 * PITCH
    assert np.median(away) == pytest.approx(PITCH, rel=0.1)
    assert len(taxels) / 10 > 0.7 * surface.area / (np.sqrt(3) / 4 * (SIDE * PITCH) ** 2)
    assert taxels.areas.sum() < surface.area
    assert taxels.areas.min() > 0


def test_no_pad_lies_where_none_may():
    _, taxels = _placed(
        sheet(width=0.2, height=0.15), allowed=lambda c: np.linalg.norm(c - [0.1, 0.07, 0], axis=1) > 0.02
    )
    assert len(taxels) >= 100
    assert np.linalg.norm(taxels.positions - [0.1, 0.07, 0], axis=1).min() > 0.018
    assert np.linalg.norm(taxels.quadrature.positions - [0.1, 0.07, 0], axis=1).min() > 0.02


def test_the_same_seed_gives_the_same_modules():
    one, two, other = (_placed(sheet(), seed=seed)[1].positions for seed in (4, 4, 5))
    assert np.array_equal(one, two)
    assert one.shape != other.shape or not np.array_equal(one, other)


@pytest.mark.parametrize("surface", [sheet(width=0.03, height=0.015), frustum(0.004, 0.004)], ids=["small", "thin"])
def test_where_none_fits_it_is_said(surface):
    with pytest.raises(SkinError, match="not one module fits"):
        _placed(surface)

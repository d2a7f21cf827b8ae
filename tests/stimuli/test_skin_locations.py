"""Places are found where the script says, and ways keep to the skin."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.skin.model.skin import Patch, Skin, Taxels
from tactile_maps.stimuli.skin_locations import STEP, SkinLocator, principal_axes
from tests.support.touch import arm, bar_skin

FOREARM = 1


@cache
def locator() -> SkinLocator:
    return SkinLocator(arm().skin)


def test_patch_is_found_by_name_and_defaults_to_the_first():
    assert locator().patch("forearm") == FOREARM
    assert locator().patch("") == 0
    with pytest.raises(SceneError, match=r"wing.*upper_arm, forearm, hand"):
        locator().patch("wing")
    with pytest.raises(SceneError, match="Cover"):
        SkinLocator(Skin(())).patch("")


def test_fractions_run_along_and_around_the_patch():
    patch = arm().skin.patches[FOREARM]
    axis = principal_axes(patch)[0]
    along = [locator().point(FOREARM, (share, 0.25)) @ axis for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert np.all(np.diff(along) > 0.02)
    around = [locator().point(FOREARM, (0.5, share)) for share in (0.0, 0.5)]
    normals = [arm().skin.normal(locator().surface_point(FOREARM, point)) for point in around]
    assert normals[0] @ normals[1] < -0.5, "half way round is the other side"


def test_place_in_link_coordinates_is_kept():
    at = arm().skin.taxel_point(200)
    point = arm().skin.position(at)
    assert at.patch == FOREARM
    assert np.allclose(locator().point(FOREARM, tuple(point)), point, atol=1e-12)
    again = locator().surface_point(FOREARM, point)
    assert np.allclose(arm().skin.position(again), point, atol=1e-12)


def test_place_off_the_skin_is_rejected_with_the_nearest_place_on_it():
    with pytest.raises(SceneError, match=r"this place is not on the skin.*50 mm away.*0\.02\]"):
        SkinLocator(bar_skin()).point(0, (0.2, 0.0, 0.07))


def test_path_between_fractions_is_on_the_skin_in_equal_steps():
    way = locator().surface_path(FOREARM, (0.1, 0.2), (0.9, 0.4))
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    assert len(way) > 100
    assert steps.max() < 0.006, "no leap: the finger strokes"
    assert np.median(steps) == pytest.approx(STEP, rel=0.2)
    assert np.allclose(locator().project(FOREARM, way), way, atol=1e-9)
    assert np.allclose(way[[0, -1]], [locator().point(FOREARM, p) for p in ((0.1, 0.2), (0.9, 0.4))], atol=1e-9)


def test_path_between_exact_places_is_straight_where_possible():
    flat = SkinLocator(bar_skin())
    way = flat.surface_path(0, (0.05, 0.0, 0.02), (0.15, 0.03, 0.02))
    assert len(way) == 106
    across = np.cross(way - way[0], way[-1] - way[0])
    assert np.abs(across).max() < 1e-12


def test_path_to_the_other_side_goes_around_the_body():
    ends = [tuple(locator().point(FOREARM, (0.5, share))) for share in (0.0, 0.5)]
    way = locator().surface_path(FOREARM, *ends)
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    assert length > 1.3 * np.linalg.norm(np.subtract(*ends)), "half a circle is longer than its diameter"
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < 0.01


def test_path_to_an_unreachable_place_contains_only_its_end():
    patch = bar_skin().patches[0]
    taxels = Taxels(
        patch.taxels.positions,
        patch.taxels.normals,
        patch.taxels.faces,
        patch.taxels.weights,
        patch.taxels.areas,
        np.zeros((0, 2)),
        patch.taxels.quadrature,
    )
    alone = SkinLocator(Skin((Patch("top", "bar", patch.surface, taxels),)))
    assert np.array_equal(alone.surface_path(0, (0.0, 0.25), (1.0, 0.25)), [alone.point(0, (1.0, 0.25))])

"""The field below a cover: every row is a force that is felt whole, and clumps change little of it."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SimulationError
from app.touch import buried as module
from app.touch.buried import buried
from app.touch.love import point_stress
from app.touch.points import skin_points
from tests.touch import arm, bar_skin, each_point_a_taxel

SKIN = bar_skin(200, finer=3)


@pytest.mark.parametrize("depth", [1e-4, 2e-3, 0.03])
def test_every_force_is_felt_whole(depth):
    for skin in (SKIN, arm().skin):
        field = buried(skin, depth)
        np.testing.assert_allclose((field.weights * skin.areas[field.taxels]).sum(axis=1), 1, rtol=1e-12)
        assert (field.weights >= 0).all()


def test_clumps_are_of_one_taxel_and_no_wider_than_three_tenths_of_a_depth():
    points, field = skin_points(SKIN), buried(SKIN, 0.02)
    assert len(field.taxels) < 0.5 * len(points.areas), "there are clumps of several points"
    for number in range(len(field.taxels)):
        members = field.clump == number
        assert members.any()
        assert len(set(points.taxel[members])) == 1
        assert np.ptp(points.positions[members], axis=0).max() <= 0.006
    assert len(buried(SKIN, 1e-4).taxels) == len(points.areas), "a shallow taxel tells all of them apart"


def test_clumps_are_felt_as_their_points():
    """With a depth of four spacings: the taxel under a point, against the sum over all points."""
    skin = each_point_a_taxel(bar_skin(finer=1))
    points, depth = skin_points(skin), 0.03
    pressures = np.zeros(len(skin))
    middle = int(np.linalg.norm(points.positions - [0.2, 0, 0.02], axis=1).argmin())
    buried(skin, depth, share=1e-3).add(pressures, np.array([middle]), np.ones(1))
    stress = point_stress(np.linalg.norm(points.positions - points.positions[middle], axis=1), depth)
    stress /= stress @ skin.areas
    np.testing.assert_allclose(pressures, stress, atol=0.03 * stress.max())


def test_forces_add_to_what_is_there():
    field, pressures = buried(SKIN, 2e-3), np.full(len(SKIN), 7.0)
    field.add(pressures, np.array([3, 500, 3]), np.array([1.0, 2.0, 0.5]))
    once = np.zeros(len(SKIN))
    field.add(once, np.array([3]), np.array([1.5]))
    field.add(once, np.array([500]), np.array([2.0]))
    np.testing.assert_allclose(pressures, 7 + once, rtol=1e-12)


def test_it_is_the_same_in_blocks_of_any_size(monkeypatch):
    whole = buried(SKIN, 2e-3)
    monkeypatch.setattr(module, "_BLOCK", 5_000)
    parts = buried(SKIN, 2e-3)
    np.testing.assert_array_equal(parts.taxels, whole.taxels)
    np.testing.assert_allclose(parts.weights, whole.weights, rtol=1e-12)


def test_a_cover_too_deep_for_its_skin_is_refused(monkeypatch):
    monkeypatch.setattr(module, "_MOST_PAIRS", 10_000)
    with pytest.raises(SimulationError, match="too deep for so fine a skin") as caught:
        buried(SKIN, 0.05)
    assert "50 mm" in str(caught.value)

"""Scenes at random with friction and three-axis taxels: Coulomb's limits hold, friction gives no energy."""

from __future__ import annotations

import pytest

from tests.scene.random_scenes import play, random_scene, unreported

SLIDING = (153, 350, 480)
"""Scenes in which bodies slide, and in which friction gave 0.08, 0.4 and 265 J before."""
QUICK = (480,)
HEAVY = 309
"""Bodies of up to 577 kg and steps of 8 ms: steps that were repeated for friction still gained energy."""


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(seed, marks=() if seed in QUICK else pytest.mark.long)
        for seed in sorted({*SLIDING, HEAVY, *range(0, 500, 7)})
    ],
)
def test_shear_keeps_coulombs_limits_and_friction_gives_no_energy(seed):
    """The limits hold for every taxel and contact; other values out of bounds are reported as well."""
    outcome = play(random_scene(seed, shear=True))
    assert unreported(outcome) == []
    if seed in SLIDING:
        assert outcome.taxel_friction > 0.9, "something slides"


def test_shear_beyond_a_limit_and_energy_of_friction_are_detected():
    outcome = play(random_scene(60, shear=True), seconds=0.05)
    assert unreported(outcome) == []
    outcome.taxel_friction = 1.001
    outcome.contact_friction = 1.001
    outcome.friction_gain = 1.0
    assert [what.split()[0] for what in unreported(outcome)] == ["shear", "friction", "1"]

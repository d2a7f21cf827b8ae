"""Random scenes: each is steady, or stops or is reported with a named cause; a force, speed, depth or energy out of
bounds is always reported.
"""

from __future__ import annotations

import pytest

from tactile_maps.scene.scene_file import scene_from_toml, scene_to_toml
from tests.scene.random_scenes import play, random_scene, unreported

pytestmark = pytest.mark.long

SCENES = 500
BY_DEFAULT = 6


def _cases() -> list:
    """All seeds; by default one of each integrator, spread over them, and one more."""
    step = SCENES // BY_DEFAULT
    usual = {number * step + number % 5 for number in range(BY_DEFAULT)}
    return [pytest.param(seed, marks=() if seed in usual else pytest.mark.long) for seed in range(SCENES)]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", _cases())
def test_values_beyond_bounds_are_reported(seed):
    outcome = play(random_scene(seed))
    assert unreported(outcome) == []


def test_light_objects_are_not_thrown_out_of_the_cover():
    """Objects of 6 and 12 mg at 16 kN/m and 0.5 ms: they left at 86 m/s when their contact had the stated stiffness."""
    outcome = play(random_scene(64))
    assert "note softer" in outcome.reported
    assert outcome.speed < 5


def test_scene_of_a_seed_is_repeatable_and_reads_back():
    assert random_scene(7) == random_scene(7) != random_scene(8)
    for seed in range(20):
        scene = scene_from_toml(random_scene(seed), name="random")
        assert scene_from_toml(scene_to_toml(scene), name="random") == scene


@pytest.mark.long
def test_missing_report_is_detected():
    """The check does not depend on the app's own reports: without them it finds the fault."""
    deep = next(outcome for outcome in map(play, map(random_scene, (5, 6, 17))) if outcome.depth > 0.010)
    assert unreported(deep) == []
    deep.reported.discard("note deep")
    assert unreported(deep) == [f"{1e3 * deep.depth:.3g} mm deep"]

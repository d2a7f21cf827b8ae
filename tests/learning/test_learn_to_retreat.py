"""The guide's example learns: two iterations on a coarse skin yield more to touches it has not seen than standing."""

import runpy
from pathlib import Path

import gymnasium
import pytest

import tactile_maps.learning  # noqa: F401  # registers

EXAMPLE = Path(__file__).resolve().parents[2] / "assets" / "guide" / "learn_to_retreat.py"


@pytest.mark.long
def test_two_iterations_of_learning_increase_the_reward():
    example = runpy.run_path(str(EXAMPLE))
    example["learn"].__globals__.update(TOUCHES=1, POLICIES=8, BEST=2, HELD_OUT=range(1000, 1003))
    arm = gymnasium.make("TactileMaps-Retreat-v0", taxels=150, max_episode_steps=60)
    before, _, after = example["learn"](arm, 2)
    assert after > 0.7 * before, "both are below zero"

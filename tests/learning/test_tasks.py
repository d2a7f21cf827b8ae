"""Every environment passes Gymnasium's checks, is reproducible with a seed, and rewards its stated goal."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tactile_maps.learning import ENVIRONMENTS

pytestmark = pytest.mark.long

TAXELS = 300


def made(name, action="joint_velocity", **others):
    return gymnasium.make(f"TactileMaps-{name}-v0", action=action, taxels=TAXELS, **others)


def course(environment, seed, steps=30):
    """Observations, rewards and ends of an episode under random actions."""
    first, _ = environment.reset(seed=seed)
    rng = np.random.default_rng(1)
    observations = [first]
    rewards = []
    for _ in range(steps):
        size = environment.action_space.shape
        seen, reward, *ends, _ = environment.step(rng.uniform(-1, 1, size).astype(np.float32))
        observations.append(seen)
        rewards.append((reward, *ends))
        if any(ends):
            break
    return observations, rewards


@pytest.mark.sampled(1)
@pytest.mark.parametrize("action", ["joint_velocity", "map_target"])
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_gymnasium_checker_accepts_the_environment_without_warnings(name, action):
    environment = gymnasium.make(name, action=action, taxels=TAXELS, render_mode="rgb_array")
    check_env(environment.unwrapped)
    environment.reset(seed=1)
    assert environment.render().dtype == np.uint8


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["Follow", "Retreat", "Explore"])
@pytest.mark.parametrize("action", ["joint_velocity", "map_target"])
def test_same_seed_gives_the_same_episode_and_another_gives_another(name, action):
    (observations, rewards), (again, same), (others, _) = (course(made(name, action), seed) for seed in (3, 3, 4))
    assert rewards == same
    assert all(np.array_equal(a[key], b[key]) for a, b in zip(observations, again, strict=True) for key in a)
    assert any(not np.array_equal(a[key], b[key]) for a, b in zip(observations, others, strict=False) for key in a)


@pytest.mark.long
def test_contact_moved_along_the_path_earns_more_than_a_resting_one():
    totals = []
    for leads in (True, False):
        environment = made("Follow", "map_target")
        total = 0.0
        touched = 0
        seen, _ = environment.reset(seed=2)
        for _ in range(160):
            touched = touched + int(seen["contact_mask"][0])
            offset = (seen["goal"] - seen["contacts"][0, :2]) / 0.02
            seen, reward, *_ = environment.step(np.clip(offset, -1, 1) if leads else np.zeros(2, np.float32))
            total += reward
        assert touched > 150, "it must be measured in contact"
        totals.append(total)
    assert totals[0] > totals[1] + 20


def test_arm_that_does_not_yield_is_penalised():
    environment = made("Retreat")
    seen, _ = environment.reset(seed=2)
    rewards = []
    for _ in range(80):
        seen, reward, *_ = environment.step(np.zeros(7, np.float32))
        rewards.append(reward)
    assert rewards[0] == 0
    assert rewards[-1] < -0.2
    assert rewards[-1] == pytest.approx(-seen["contacts"][:, 2].sum() / 5.0, rel=1e-5)


def test_new_places_are_rewarded_once():
    environment = made("Explore", "map_target")
    environment.reset(seed=5)
    observations, rewards = course(environment, 5, steps=60)
    assert sum(reward for reward, *_ in rewards) == observations[-1]["visited"].sum() >= 1


@pytest.mark.long
def test_environments_step_in_two_processes():
    environments = gymnasium.make_vec(
        "TactileMaps-Follow-v0",
        num_envs=2,
        vectorization_mode="async",
        vector_kwargs={"context": "spawn"},
        taxels=TAXELS,
    )
    try:
        environments.reset(seed=1)
        seen, rewards, *_ = environments.step(np.zeros((2, 7), np.float32))
    finally:
        environments.close()
    assert rewards.shape == (2,)
    assert not np.array_equal(seen["goal"][0], seen["goal"][1])

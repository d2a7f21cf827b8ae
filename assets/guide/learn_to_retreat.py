"""Learns to yield to touch: ``python assets/guide/learn_to_retreat.py``, about a minute on one core.

A linear policy computes joint velocities from the strongest contact's force and place on the map. The cross-entropy
method draws policies around a mean, tests each on the same touches, and moves the mean towards the best ones.
"""

from __future__ import annotations

import sys
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

TOUCHES = 4
"""Episodes on which each policy of an iteration is tried."""
POLICIES = 16
BEST = 4
HELD_OUT = range(1000, 1010)
"""Seeds of the touches that no policy is learnt on."""


def features(seen: dict[str, NDArray[Any]], middle: NDArray[Any]) -> NDArray[Any]:
    """(3,) the force, by itself and times the place on the map from its middle."""
    x, y, force, _ = seen["contacts"][0]
    place = np.array([1.0, (x - middle[0]) / 0.1, (y - middle[1]) / 0.1])
    return np.asarray(min(force / 5.0, 1.0) * place)


def episode_return(environment: Any, weights: NDArray[Any], seed: int) -> float:
    """The sum of rewards under a policy, weights (3, joints)."""
    seen, _ = environment.reset(seed=seed)
    middle = environment.unwrapped.prepared.map.bounds.mean(axis=0)
    total = 0.0
    over = False
    while not over:
        action = np.clip(features(seen, middle) @ weights, -1, 1)
        seen, reward, terminated, truncated, _ = environment.step(action.astype(np.float32))
        total = total + reward
        over = terminated or truncated
    return total


def learn(environment: Any, iterations: int, *, seed: int = 0) -> list[float]:
    """Mean return on the held-out touches before the first iteration and after each."""
    rng = np.random.default_rng(seed)
    mean, spread = np.zeros((2, 3, environment.action_space.shape[0]))
    spread = spread + 1.0

    def held_out() -> float:
        return float(np.mean([episode_return(environment, mean, touch) for touch in HELD_OUT]))

    curve = [held_out()]
    for _ in range(iterations):
        touches = rng.integers(500, size=TOUCHES)
        policies = mean + spread * rng.standard_normal((POLICIES, *mean.shape))
        returns = [sum(episode_return(environment, policy, int(t)) for t in touches) for policy in policies]
        best = policies[np.argsort(returns)[-BEST:]]
        mean = best.mean(axis=0)
        spread = best.std(axis=0) + 0.05
        curve.append(held_out())
    return curve


if __name__ == "__main__":
    arm = gymnasium.make("tactile_maps.learning:TactileMaps-Retreat-v0", taxels=300)
    for number, mean_return in enumerate(learn(arm, iterations=int(sys.argv[1]) if sys.argv[1:] else 10)):
        sys.stdout.write(f"{number:3d}  {mean_return:8.2f}\n")
        sys.stdout.flush()

"""Registration of the environments with Gymnasium.

``gymnasium.make("tactile_maps.learning:TactileMaps-Follow-v0")`` imports this package by itself; since version 1.0,
Gymnasium does not read entry points of installed packages.
"""

from __future__ import annotations

from tactile_maps.core.errors import LearningError, install_line

ENVIRONMENTS = {
    "TactileMaps-Follow-v0": "tactile_maps.learning.tasks:FollowEnvironment",
    "TactileMaps-Retreat-v0": "tactile_maps.learning.tasks:RetreatEnvironment",
    "TactileMaps-Explore-v0": "tactile_maps.learning.tasks:ExploreEnvironment",
}
"""Class by name."""
EPISODE_STEPS = 200
"""Number of steps after which an episode is truncated."""


def register_environments() -> None:
    """Register the environments with Gymnasium, unless they are registered already.

    Raises:
        LearningError: Gymnasium is not installed.
    """
    try:
        from gymnasium.envs.registration import register, registry
    except ImportError as error:
        remedy = install_line("learning")
        problem = "learning needs a package that is not installed"
        raise LearningError(problem, value="gymnasium", remedy=remedy) from error
    for name, entry_point in ENVIRONMENTS.items():
        if name not in registry:
            register(id=name, entry_point=entry_point, max_episode_steps=EPISODE_STEPS)

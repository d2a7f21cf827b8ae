"""Actions are applied unchanged or rejected with a named error; a failure of the physics ends the episode."""

import numpy as np
import pytest

from tactile_maps.core.errors import LearningError, SimulationError
from tactile_maps.learning.environment import SkinEnvironment
from tactile_maps.learning.tasks import FollowEnvironment, RetreatEnvironment


@pytest.mark.parametrize(
    "action",
    [np.full(7, 1.1), *(pytest.param(action, marks=pytest.mark.long) for action in (np.zeros(3), np.full(7, np.nan)))],
)
def test_invalid_action_is_rejected(action):
    environment = FollowEnvironment(taxels=60)
    environment.reset(seed=1)
    with pytest.raises(LearningError, match="Give 7 numbers from -1 to 1"):
        environment.step(action)


def test_step_before_reset_is_rejected():
    with pytest.raises(LearningError, match="Call reset"):
        FollowEnvironment(taxels=60).step(np.zeros(7))


@pytest.mark.parametrize("choice", [{"action": "torque"}, {"render_mode": "human"}])
def test_unknown_choice_is_rejected(choice):
    with pytest.raises(LearningError, match="Choose"):
        FollowEnvironment(taxels=60, **choice)


def test_joints_move_at_the_speed_of_the_action():
    environment = RetreatEnvironment(taxels=60)
    seen, _ = environment.reset(seed=1)
    start = seen["position"][6]
    action = np.eye(7)[6]
    for _ in range(50):
        seen, *_, info = environment.step(action)
    assert seen["position"][6] - start == pytest.approx(0.5, abs=0.1), "0.5 rad/s for a second"
    assert not info["at_limit"]


def test_physics_error_ends_the_episode():
    environment = FollowEnvironment(taxels=60)
    environment.reset(seed=1)

    def gives_up(_frame):
        raise SimulationError("the simulation left the numbers")

    with environment.session.watched(gives_up):
        _, reward, terminated, truncated, info = environment.step(np.zeros(7))
    assert (reward, terminated, truncated) == (-10.0, True, False)
    assert "left the numbers" in info["failure"]


def test_environment_without_required_methods_cannot_be_created():
    with pytest.raises(TypeError, match="begin.*judge"):
        SkinEnvironment(taxels=60)  # type: ignore[abstract]

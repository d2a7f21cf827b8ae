"""Base class of the environments: a session of the touched arm, two kinds of action, and the steps of an episode."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, Literal, TypeAlias, get_args

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import LearningError, PluginError, SimulationError
from tactile_maps.learning.observation import FrameObserver, Observation
from tactile_maps.learning.touched_arm import prepared_arm
from tactile_maps.maps.pressure_colours import colour_image
from tactile_maps.session.inputs import ControlChanged, RestChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session

ActionKind: TypeAlias = Literal["joint_velocity", "map_target"]
TICKS_PER_STEP = 4
"""Number of control ticks per step: with ticks of 5 ms a policy acts 50 times per second."""
MAX_SPEED = 0.5
"""Speed of a joint of the target posture at action 1 [rad/s]."""
MAX_OFFSET = 0.02
"""Distance from the contact to its target at action 1 along an axis of the map [m]."""
FULL_SCALE = 50.0
"""Upper end of the colour scale of the rendered tactile image [kPa]."""
FAULT_REWARD = -10.0
"""Reward of the step at which the simulation fails."""


class SkinEnvironment(gymnasium.Env[Observation, NDArray[np.float32]], ABC):
    """A touched arm with tactile skin. Subclasses define what touches it, the goal and the end of an episode.

    Actions are from -1 to 1. ``joint_velocity`` (joints,): each joint of the posture that the arm's impedance
    controller holds moves with up to 0.5 rad/s; it stops at the joint's limit, which ``info["at_limit"]`` reports.
    ``map_target`` (2,): the target of the contact is up to 2 cm from the contact along the axes of the map, and the
    admittance controller moves it there; a target off the skin is ignored, which ``info["off_map"]`` reports. An error
    of the simulation or of a plug-in ends the episode with a reward of -10 and ``info["failure"]``.

    Args:
        action: Kind of action.
        taxels: Number of taxels on the forearm.
        prepared: Another scene to learn in; ``taxels`` is then ignored.
        render_mode: ``rgb_array`` for the tactile image in colours.

    Raises:
        LearningError: The kind of action or the render mode is unknown.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012  # Gymnasium's name
    force_goal = 2.0
    """Target force of the admittance controller with ``map_target`` [N]."""

    def __init__(
        self,
        *,
        action: ActionKind = "joint_velocity",
        taxels: int = 1000,
        prepared: PreparedScene | None = None,
        render_mode: str | None = None,
    ) -> None:
        _check_choice("action", action, get_args(ActionKind))
        _check_choice("render_mode", render_mode, (None, *self.metadata["render_modes"]))
        self.render_mode = render_mode
        self._kind = action
        self.prepared = prepared or prepared_arm(taxels)
        self._observer = FrameObserver(self.prepared.robot, self.prepared.map)
        self._lower, self._upper = joint_limits(self.prepared.robot)
        size = len(self._lower) if action == "joint_velocity" else 2
        self.action_space = spaces.Box(-1.0, 1.0, (size,), np.float32)
        self.observation_space = spaces.Dict({**self._observer.spaces, **self.goal_spaces()})
        self._session: Session | None = None

    def goal_spaces(self) -> dict[str, Any]:
        """Return the spaces of what ``goal`` adds to the observation."""
        return {}

    def goal(self) -> Observation:
        """Return the goal as part of the observation."""
        return {}

    @abstractmethod
    def begin(self, settings: ControlSettings, seed: int) -> Session:
        """Return the session of a new episode, randomised by ``np_random``."""

    @abstractmethod
    def judge(self) -> tuple[float, bool]:
        """Return the reward of the last step, and whether it ends the episode."""

    @property
    def session(self) -> Session:
        """Session of the episode.

        Raises:
            LearningError: ``reset`` has not been called.
        """
        if self._session is None:
            raise LearningError("the environment has no episode yet", remedy="Call reset() before step() and render()")
        return self._session

    @property
    def contact(self) -> FloatArray | None:
        """(2,) position of the strongest contact on the map [m]; None without a contact."""
        regions = self.session.frame.regions
        return regions[0].map_point if regions else None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; it is reproducible bit for bit by its seed. Cost: 50 ms for 1000 taxels."""
        super().reset(seed=seed)
        settings = ControlSettings(stiffness=20.0)
        if self._kind == "map_target":
            settings = replace(settings, controller="admittance", task="hold_point", force_goal=self.force_goal)
        self._session = self.begin(settings, int(self.np_random.integers(2**31)))
        self._rest = self.prepared.robot.home
        return self._observation(), {}

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Act for four ticks.

        Raises:
            LearningError: The action has another shape, or a number outside of -1 to 1.
        """
        session = self.session
        values = self._checked(action)
        info = self._move_rest(values) if self._kind == "joint_velocity" else self._move_target(values)
        try:
            for _ in range(TICKS_PER_STEP):
                session.tick()
        except (SimulationError, PluginError) as error:
            return self._observation(), FAULT_REWARD, True, False, {**info, "failure": str(error)}
        reward, ended = self.judge()
        return self._observation(), float(reward), ended, False, info

    def render(self) -> Any:
        """Return the tactile image in colours (rows, columns, 3), up to 50 kPa; None without a ``render_mode``."""
        if self.render_mode is None:
            return None
        return colour_image(self._observer.image, self.session.frame.pressures, FULL_SCALE)

    def _observation(self) -> Observation:
        return {**self._observer.observe(self.session.frame), **self.goal()}

    def _checked(self, action: NDArray[np.float32]) -> FloatArray:
        values = np.asarray(action, dtype=np.float64)
        shape = self.action_space.shape
        if values.shape != shape or not (np.abs(values) <= 1.0).all():  # NaN compares false
            remedy = f"Give {shape[0] if shape else 0} numbers from -1 to 1"
            raise LearningError("the action is not in the action space", value=values.tolist(), remedy=remedy)
        return values

    def _move_rest(self, velocity: FloatArray) -> dict[str, Any]:
        seconds = TICKS_PER_STEP * self.prepared.scene.tick
        requested = self._rest + MAX_SPEED * seconds * velocity
        self._rest = np.clip(requested, self._lower, self._upper)
        self.session.submit(RestChanged(tuple(map(float, self._rest))))
        return {"at_limit": bool((requested != self._rest).any())}

    def _move_target(self, offset: FloatArray) -> dict[str, Any]:
        contact = self.contact
        if contact is None:
            return {"off_map": False}
        target = contact + MAX_OFFSET * offset
        if self.prepared.map.to_body(target) is None:
            return {"off_map": True}
        path = ((float(target[0]), float(target[1])),)
        self.session.submit(ControlChanged(replace(self.session.settings, path=path)))
        return {"off_map": False}


def _check_choice(name: str, value: object, known: tuple[object, ...]) -> None:
    if value not in known:
        remedy = f"Choose {' or '.join(map(str, known))}"
        raise LearningError(f"unknown value of {name}", place=name, value=value, remedy=remedy)

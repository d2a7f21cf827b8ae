"""The controller on measured data: measured posture and contacts in, desired joint velocities out.

Nothing is sent from here, see ``motion_output``. The controller is the one that moves the simulated arm. Because no
robot follows its desired posture here, that posture leads the measured one by at most what the controllers themselves
allow, and the limit is reported then.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit
from tactile_maps.control.motion.observation import Observation
from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import LiveError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.session.facts import MeasuredFacts
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin

LONGEST_STEP = 0.1
"""A longer time between readings [s] is too long for contact control: the controller restarts."""

NOISE_DEVIATIONS = 3.0
"""Standard deviations of noise that the force on taxels without a contact must exceed to count."""
_TIMING_SHARE = 0.05
"""Weight of the newest interval between two readings in the period that the controllers receive."""


@dataclass(frozen=True, eq=False)
class RequestedMotion(ArrayFields):
    """Joint motion until the next reading.

    Attributes:
        time: Time of the reading that it follows from, from the session's start [s].
        velocity: (joints,) [rad/s, or m/s for a slide].
        force: Force of the strongest contact [N]; 0 without one.
        limits: What limits the controller, or stopped it.
    """

    time: float
    velocity: FloatArray
    force: float
    limits: tuple[Limit, ...] = ()


class MeasuredController:
    """A controller that uses a measured skin. Mutable; ``reset`` discards its state.

    Without contact it holds the posture in which it is started instead of the model's home posture, to which a real
    robot should not move by itself.

    Args:
        robot: The measured robot.
        map_: Map of the skin; ``use_map`` changes it.
        settings: Settings of the controller.

    Raises:
        SceneError: A setting is out of range.
        RobotError: Same as for ``ControllerManager.prepare``.
    """

    def __init__(self, robot: Robot, map_: TactileMap, settings: ControlSettings) -> None:
        self._manager = ControllerManager(robot, map_, settings)
        self._manager.prepare((settings.task,), map_)
        self._map = map_
        self._before: tuple[float, FloatArray] | None = None
        self._newest: RequestedMotion | None = None

    @property
    def settings(self) -> ControlSettings:
        """Current settings."""
        return self._manager.settings

    def use(self, settings: ControlSettings) -> None:
        """Change the settings; raises SceneError and keeps the previous ones if they are invalid."""
        self._manager.prepare((settings.task,), self._map)
        self._manager.settings = settings

    def use_map(self, map_: TactileMap) -> None:
        """Use another map of the same skin from the next reading on."""
        if map_ is not self._map:
            self._map = map_
            self._manager.use(map_)

    def reset(self) -> None:
        """Restart at the next reading, in its posture."""
        self._manager.reset()
        self._before = None

    def command(self, frame: Frame, facts: MeasuredFacts) -> RequestedMotion:
        """Return the motion that follows from a measured frame; zero at first and after a gap.

        Raises:
            LiveError: The readings are not forces, a joint is not measured, so that the position of the skin is
                unknown, or the controller works by torques and has no desired motion.

        Cost: 1 to 3 ms for 1,000 taxels.
        """
        check_controllable(frame, facts)
        if self.settings.controller == "impedance":
            remedy = "Choose another controller, such as Hold force or Hybrid"
            raise LiveError("impedance control has no desired motion", place="controller", remedy=remedy)
        strongest = strongest_force(frame)
        step = None if self._before is None else frame.time - self._before[0]
        if step == 0 and self._newest is not None:  # another part of the skin, measured at the same time
            return replace(self._newest, force=strongest)
        if step is None or not 0 < step <= LONGEST_STEP:
            return self._begin(frame, strongest)
        self._manager.readings = self._timing(step)
        readable = bool(np.isfinite(frame.pressures).all())
        command = self._manager.command(Observation(frame.posture, frame.velocity, frame.regions, step, readable))
        assert self._before is not None
        velocity = (command.posture - self._before[1]) / step
        self._before = frame.time, command.posture
        self._newest = RequestedMotion(frame.time, velocity, strongest, self._manager.why_limited)
        return self._newest

    def _begin(self, frame: Frame, strongest: float) -> RequestedMotion:
        self._manager.reset()
        self._manager.rest = frame.posture
        self._before = frame.time, frame.posture
        self._newest = RequestedMotion(frame.time, np.zeros(len(frame.posture)), strongest)
        return self._newest

    def _timing(self, step: float) -> SensorTiming:
        """Return the period of the stream; the delay of the readings is unknown to a receiver."""
        before = self._manager.readings
        period = step if before is None else before.period + _TIMING_SHARE * (step - before.period)
        return SensorTiming(period)


def strongest_force(frame: Frame) -> float:
    """Return the largest force of a contact [N]; 0 without one, NaN if one is not a number."""
    return float(np.max([region.force for region in frame.regions], initial=0.0))


class PatchForce(NamedTuple):
    """Force on one patch.

    Attributes:
        patch: Name of the patch.
        total: Force of its strongest contact plus the force on its taxels outside contacts [N].
        below: The latter [N], minus its noise; never negative.
    """

    patch: str
    total: float
    below: float


def strongest_patch(frame: Frame, skin: Skin, noise: TaxelNoise | None) -> PatchForce:
    """Return the force on the most loaded patch, regardless of the contact threshold. Cost: 0.1 ms for 5,000 taxels.

    Args:
        frame: Frame with calibrated pressures.
        skin: Skin of the frame.
        noise: Noise of the taxels; the sum over taxels must exceed ``NOISE_DEVIATIONS`` standard deviations of it.
    """
    patches = len(skin.patches)
    free = np.ones(len(skin), dtype=bool)
    contact = np.zeros(patches)
    for region in frame.regions:
        free[region.taxels] = False
        touched = np.unique(skin.patch_of[region.taxels])
        contact[touched] = np.maximum(contact[touched], region.force)
    taxels = np.flatnonzero(free)
    patch_of = skin.patch_of[taxels]
    areas = skin.areas[taxels]
    signed = np.bincount(patch_of, frame.pressures[taxels] * areas, minlength=patches)
    below: FloatArray = np.asarray(signed, dtype=np.float64)
    if noise is not None:
        variance = np.bincount(patch_of, (noise.sd[taxels] * areas) ** 2, minlength=patches)
        below = below - NOISE_DEVIATIONS * np.sqrt(variance)
    below = np.maximum(below, 0.0)
    total = contact + below
    most = int(total.argmax())
    return PatchForce(skin.patches[most].name, float(total[most]), float(below[most]))


def check_controllable(frame: Frame, facts: MeasuredFacts) -> None:
    """Check that contacts can be controlled with a measured frame.

    Raises:
        LiveError: See ``MeasuredController.command``.
    """
    if frame.units is not ReadingUnits.CALIBRATED:
        remedy = "Calibrate the skin and show it in kPa"
        raise LiveError("forces cannot be controlled without a calibration", value=frame.units.unit, remedy=remedy)
    if facts.unheard_joints:
        missing = f"{facts.unheard_joints} of {len(frame.posture)} joints"
        raise LiveError("the robot's posture is not known", value=missing, remedy="Send every joint's position")

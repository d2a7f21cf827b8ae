"""What a controller would do with a real robot: measured posture and contacts in, wanted joint velocities out.

Nothing is sent from here: see ``motion_output``. The controller is the one that moves the simulated arm; its wanted
posture is followed by nobody here, so it runs ahead of the found one by no more than the controllers themselves allow,
and is told as being held back then.
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
from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.core.errors import LiveError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.session.measured_session import MeasuredFacts
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame
from tactile_maps.skin.model.skin import Skin

LONGEST_STEP = 0.1
"""Readings further apart [s] are no stream that a contact is controlled by: the controller starts anew."""

NOISE_DEVIATIONS = 3.0
"""Standard deviations of noise that the force on taxels without a contact must exceed to count."""
_TIMING_SHARE = 0.05
"""Of the newest interval between two readings in the period that the controllers are told."""


@dataclass(frozen=True, eq=False)
class WantedMotion:
    """What the joints should do until the next reading.

    Attributes:
        time: Of the reading that it answers, from the session's start [s].
        velocity: (joints,) [rad/s, or m/s for a slide].
        force: Of the strongest contact [N]; 0 without one.
        limits: What bounds the controller, or stopped it.
    """

    time: float
    velocity: FloatArray
    force: float
    limits: tuple[Limit, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, "velocity")


class MeasuredController:
    """A controller that reads a measured skin. Mutable; ``reset`` forgets the past.

    It keeps the posture in which it is started while nothing touches, not the model's home, in which no one may want a
    real robot to go by itself.

    Args:
        robot: As it is measured.
        map_: Of the skin; ``use`` takes another.
        settings: Of the controller.

    Raises:
        SceneError: A setting is out of range.
        RobotError: As ``ControllerManager.prepare``.
    """

    def __init__(self, robot: Robot, map_: TactileMap, settings: ControlSettings) -> None:
        self._manager = ControllerManager(robot, map_, settings)
        self._manager.prepare((settings.task,), map_)
        self._map = map_
        self._before: tuple[float, FloatArray] | None = None
        self._newest: WantedMotion | None = None

    @property
    def settings(self) -> ControlSettings:
        """In force."""
        return self._manager.settings

    def use(self, settings: ControlSettings) -> None:
        """Take other settings; raises SceneError, and the last good ones stay."""
        self._manager.prepare((settings.task,), self._map)
        self._manager.settings = settings

    def use_map(self, map_: TactileMap) -> None:
        """Take another map of the same skin from the next reading on; nothing for the same."""
        if map_ is not self._map:
            self._map = map_
            self._manager.use(map_)

    def reset(self) -> None:
        """Begin anew at the next reading, in the posture that is found then."""
        self._manager.reset()
        self._before = None

    def command(self, frame: Frame, facts: MeasuredFacts) -> WantedMotion:
        """The answer to a measured frame; at first, and after a gap, to stand still.

        Raises:
            LiveError: The readings are no forces, not all joints are measured, so that the skin's place is not known,
                or the controller yields by torques and wants no motion.

        Cost: 1 to 3 ms for 1,000 taxels.
        """
        check_controllable(frame, facts)
        if self.settings.controller == "impedance":
            remedy = "Choose another controller, such as hold_force or hybrid"
            raise LiveError("impedance yields by torques, and wants no motion", place="controller", remedy=remedy)
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
        self._newest = WantedMotion(frame.time, velocity, strongest, self._manager.why_limited)
        return self._newest

    def _begin(self, frame: Frame, strongest: float) -> WantedMotion:
        self._manager.reset()
        self._manager.rest = frame.posture
        self._before = frame.time, frame.posture
        self._newest = WantedMotion(frame.time, np.zeros(len(frame.posture)), strongest)
        return self._newest

    def _timing(self, step: float) -> SensorTiming:
        """As far as the stream itself tells: the delay of the readings is not known to a receiver."""
        before = self._manager.readings
        period = step if before is None else before.period + _TIMING_SHARE * (step - before.period)
        return SensorTiming(period)


def strongest_force(frame: Frame) -> float:
    """Largest force of a contact [N]; 0 without one, NaN where one is not a number."""
    return float(np.max([region.force for region in frame.regions], initial=0.0))


class PatchForce(NamedTuple):
    """Force on one patch.

    Attributes:
        patch: Its name.
        total: Of its strongest contact, and of its taxels that belong to no contact [N].
        below: Of the latter [N], less their noise; never negative.
    """

    patch: str
    total: float
    below: float


def strongest_patch(frame: Frame, skin: Skin, noise: TaxelNoise | None) -> PatchForce:
    """Return the force on the patch that bears most, whatever the contact threshold. Cost: 0.1 ms for 5,000 taxels.

    Args:
        frame: With calibrated pressures.
        skin: Whose taxels it has.
        noise: Of the taxels; the sum over taxels must exceed ``NOISE_DEVIATIONS`` standard deviations of it.
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
    """Refuse a measured frame that no contact can be controlled by.

    Raises:
        LiveError: See ``MeasuredController.command``.
    """
    if frame.units is not ReadingUnits.CALIBRATED:
        remedy = "Calibrate the skin and show it in kPa"
        raise LiveError("without a calibration no force is known to control", value=frame.units.unit, remedy=remedy)
    if facts.unheard_joints:
        missing = f"{facts.unheard_joints} of {len(frame.posture)} joints"
        raise LiveError("the robot's posture is not known", value=missing, remedy="Send every joint's position")

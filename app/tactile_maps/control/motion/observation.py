"""Inputs of controllers and tasks at a control tick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch
from tactile_maps.control.motion.approach_speed import ApproachSpeed
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import ActiveLimits
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.unmeasured_force import DriveTorques
from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration


@dataclass(frozen=True, eq=False)
class Observation:
    """State of robot and skin at a control tick; a controller returns the command for the next ``dt`` seconds.

    Attributes:
        posture: (n,) joint positions [rad, or m for a slide].
        velocity: (n,) joint velocities [rad/s, or m/s for a slide].
        contacts: All contacts, the strongest first.
        dt: Time until the next command [s].
        readable: True if all taxels read finite numbers. If not, a contact may be missing from ``contacts`` although it
            persists, and controllers that read contacts stop.
        mismatch: Several contacts that were detected as one and whose wrench no single contact explains; controllers
            that read contacts stop. None without such contacts.
        torques: Drive torques since the previous command; None if unknown. Force that the skin does not measure is
            detected only with them.
        approach: Bound on the speed of an approach; None without one.
    """

    posture: FloatArray
    velocity: FloatArray
    contacts: tuple[ContactRegion, ...]
    dt: float
    readable: bool = True
    mismatch: WrenchMismatch | None = None
    torques: DriveTorques | None = None
    approach: ApproachSpeed | None = None


@dataclass(frozen=True, eq=False)
class TaskTick:
    """Inputs of a task in one tick, on a map.

    Attributes:
        settings: Current settings; another task starts from its beginning. A changed path continues at its nearest
            point.
        regions: All contacts, the strongest first.
        map_kinematics: Kinematics of the map; on another map a path is projected again, and a place stays the same.
        configuration: The robot at its current posture.
        dt: Time since the last tick [s].
        limits: Collects the limits of the task.
    """

    settings: ControlSettings
    regions: Sequence[ContactRegion]
    map_kinematics: MapKinematics
    configuration: Configuration
    dt: float
    limits: ActiveLimits

"""Speed and effort limits of joints, read from a robot's file.

URDF states both in ``<limit velocity effort>``; MuJoCo reads the effort. MJCF states them by its actuators: the force
range of a drive, the control range of a motor (a force) and of a velocity servo (a speed), each through its gear.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, places_finding


@dataclass(frozen=True)
class DriveLimits:
    """Largest speed and effort of the drive of one joint.

    Attributes:
        speed: [rad/s, or m/s for a slide]; inf where no limit is stated.
        effort: [N m, or N for a slide]; inf where no limit is stated.
    """

    speed: float = math.inf
    effort: float = math.inf


def urdf_limits(root: Element, findings: list[Finding]) -> dict[str, DriveLimits]:
    """Return the speed limits of a URDF tree by joint name; MuJoCo reads the efforts.

    Args:
        root: The tree.
        findings: Receives the speeds that are not positive numbers, which are not used.
    """
    limits = dict[str, DriveLimits]()
    unused = list[str]()
    for joint in root.iter("joint"):
        stated = joint.find("limit")
        text = None if stated is None else stated.get("velocity")
        if text is None:
            continue
        name = joint.get("name", "")
        speed = _number(text)
        if speed > 0:
            limits[name] = DriveLimits(speed=speed)
        elif joint.get("type") not in ("fixed", "floating"):
            unused.append(f"{name}: {text}")
    findings += places_finding("velocity-limit", unused, "velocity limit not used: it is not a positive number")
    return limits


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


_DRIVES = ("general", "motor", "position", "velocity", "intvelocity")
_SETTINGS = frozenset(
    (
        "biasprm",
        "biastype",
        "class",
        "ctrllimited",
        "ctrlrange",
        "forcelimited",
        "forcerange",
        "gainprm",
        "gaintype",
        "gear",
        "joint",
        "kp",
        "kv",
    )
)


def actuator_limits(
    actuators: Sequence[Element], defaults: Sequence[Element], findings: list[Finding], *, source: str
) -> dict[str, DriveLimits]:
    """Return the limits that the actuators of an MJCF file set to its joints, by joint name.

    Several actuators of one joint add their efforts; the smallest of their speeds counts.

    Args:
        actuators: Contents of its ``<actuator>`` sections; those that do not drive a joint are ignored.
        defaults: Its ``<default>`` sections.
        findings: Receives the actuators that MuJoCo cannot read.
        source: Name of the file in findings.
    """
    root = Element("mujoco")
    for default in defaults:
        _copy_default(default, root)
    section = SubElement(root, "actuator")
    for actuator in actuators:
        if actuator.tag in _DRIVES and actuator.get("joint"):
            SubElement(section, actuator.tag, _settings(actuator))
    if not len(section):
        return {}
    try:
        spec = mujoco.MjSpec.from_string(tostring(root, encoding="unicode"))
    except (ValueError, mujoco.FatalError) as error:
        message = " ".join(str(error).split()).removeprefix("XML Error: ")
        findings.append(Finding("actuators", source, f"limits of its actuators not read: {message}"))
        return {}
    limits = dict[str, DriveLimits]()
    for drive in spec.actuators:
        known = limits.get(drive.target)
        effort = _effort(drive) + (0.0 if known is None else known.effort)
        speed = min(_speed(drive), math.inf if known is None else known.speed)
        limits[drive.target] = DriveLimits(speed, effort)
    return limits


def _settings(element: Element) -> dict[str, str]:
    return {name: value for name, value in element.attrib.items() if name in _SETTINGS}


def _copy_default(default: Element, parent: Element) -> None:
    """Copy the settings of actuators only: other settings may refer to assets."""
    copy = SubElement(parent, "default", _settings(default))
    for child in default:
        if child.tag == "default":
            _copy_default(child, copy)
        elif child.tag in _DRIVES:
            SubElement(copy, child.tag, _settings(child))


def _effort(drive: mujoco.MjsActuator) -> float:
    """Return the largest effort of a drive at its joint [N m, or N]."""
    gear = abs(float(drive.gear[0]))
    force = smaller_bound(drive.forcelimited, drive.forcerange)
    if drive.gaintype == mujoco.mjtGain.mjGAIN_FIXED and drive.biastype == mujoco.mjtBias.mjBIAS_NONE:
        force = min(force, abs(float(drive.gainprm[0])) * smaller_bound(drive.ctrllimited, drive.ctrlrange))
    return gear * force if gear > 0 else math.inf


def _speed(drive: mujoco.MjsActuator) -> float:
    """Return the largest speed that a velocity servo can be set to [rad/s, or m/s]; inf for other drives."""
    gear = abs(float(drive.gear[0]))
    gain = float(drive.gainprm[0])
    servo = drive.biastype == mujoco.mjtBias.mjBIAS_AFFINE and gain > 0
    if not (servo and gear > 0 and drive.biasprm[1] == 0 and drive.biasprm[2] == -gain):
        return math.inf
    return smaller_bound(drive.ctrllimited, drive.ctrlrange) / gear


def smaller_bound(limited: int, ends: FloatArray) -> float:
    """Return the smaller magnitude of both ``ends`` (2,) of a range, without those that are zero; inf without limit."""
    sizes = [abs(float(end)) for end in ends if end != 0]
    return min(sizes, default=math.inf) if limited != mujoco.mjtLimited.mjLIMITED_FALSE else math.inf


def limit_efforts(joints: Collection[mujoco.MjsJoint], limits: Mapping[str, DriveLimits]) -> None:
    """Set the efforts to the joints of a spec, where they do not state a smaller one themselves; both ways alike."""
    for joint in joints:
        own = smaller_bound(joint.actfrclimited, np.asarray(joint.actfrcrange))
        effort = min(own, limits[joint.name].effort if joint.name in limits else math.inf)
        if math.isfinite(effort):
            joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE
            joint.actfrcrange = [-effort, effort]

"""Objects of a scene that overlap the robot at the start, as findings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mujoco

from tactile_maps.core.errors import Finding
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name, is_object, plain_name
from tactile_maps.simulation.model.object_geoms import is_simulated
from tactile_maps.skin.model.skin import Skin

OVERLAP = "starts-inside"
"""Kind of these findings."""
_LEAST = 1e-3
"""Smallest depth of an overlap that is reported [m]."""


def with_overlaps(
    robot: Robot, skin: Skin, effects: Effects, objects: Sequence[SceneObject]
) -> tuple[SceneObject, ...]:
    """Return the objects with a finding for each that starts deeper than 1 mm in a link of the robot.

    Objects that are not in the physics under these effects have none.

    Raises:
        RobotError: MuJoCo refuses the model.

    Cost: that of compiling the model, if objects are simulated.
    """
    if not any(is_simulated(thing.spec.kind, effects) for thing in objects):
        return tuple(objects)
    model = assemble(robot, skin, replace(effects, skin="point"), objects=objects)
    data = mujoco.MjData(model)
    data.qpos[: len(robot.joints)] = robot.home
    mujoco.mj_fwdPosition(model, data)
    deepest: dict[str, tuple[float, str]] = {}
    for depth, geoms in zip((-data.contact.dist).tolist(), data.contact.geom.tolist(), strict=True):
        names = sorted((model.body(int(model.geom_bodyid[geom])).name for geom in geoms), key=is_object)
        if is_object(names[1]) and not is_object(names[0]) and names[0] != "world":
            deepest[names[1]] = max(deepest.get(names[1], (_LEAST, "")), (depth, plain_name(names[0])))
    return tuple(_with_finding(thing, *deepest.get(body_name(thing.spec), (0.0, ""))) for thing in objects)


def _with_finding(thing: SceneObject, depth: float, link: str) -> SceneObject:
    if not link:
        return thing
    action = f"starts {1e3 * depth:.3g} mm deep in {link}, which pushes it out at once; move it by at least that much"
    return replace(thing, findings=(*thing.findings, Finding(OVERLAP, thing.spec.name, action)))

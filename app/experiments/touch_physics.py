"""The contact models that the physics runs itself, on the grounds: a ball held where it presses, and nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from app.arrays import FloatArray
from app.control.command import JointCommand
from app.experiments.flat_map import SIDE
from app.experiments.touch_skins import LENGTH, RADIUS, Ground
from app.geometry.mesh import Mesh
from app.robots.robot import Link, Robot
from app.scene.bodies import primitive
from app.scene.effects import Effects, SkinModel
from app.scene.objects import Body, ObjectSpec
from app.simulation.simulation import Simulation
from app.touch.layer import Layer
from app.touch.load import Load
from app.touch.shapes import Ball

PHYSICS: Mapping[str, str] = {"foundation": "Foundation", "depth": "Depth"}
"""Models that are told nothing: they see how deep the ball is. As shown to people."""
_FIXED = """<mujoco model="ground"><worldbody><body name="{link}"><geom type="{solid}" pos="{at}" size="{size}"/>
</body></worldbody></mujoco>"""


def held(ground: Ground, model: SkinModel, load: Load) -> Simulation:
    """A simulation of the ball of ``load`` held in the skin of ``ground``, both fixed, before its first step.

    Raises:
        TypeError: What presses is no ball.
    """
    if not isinstance(load.shape, Ball):
        raise TypeError(f"a ball is meant to press, not {load.shape}")
    x, y, z = load.pose.translation.tolist()
    spec = ObjectSpec("ball", "sphere", (load.shape.radius,), at=(x, y, z))
    effects = Effects(gravity="off", contact="environment", fingers=False, skin=model)
    return Simulation(_fixed(ground), ground.skin, effects, objects=(Body(spec, primitive(spec)),), layer=Layer())


def step(simulation: Simulation) -> FloatArray:
    """One step of the physics and a reading (taxels,) [Pa]: what the taxels say is made in the step."""
    simulation.step(1, _STILL)
    return simulation.sense()


_STILL = JointCommand(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))


def _fixed(ground: Ground) -> Robot:
    """A robot of one solid link that cannot move, under the skin of ``ground``."""
    link = ground.skin.patches[0].link
    if np.isinf(ground.radius):
        spec, at = ObjectSpec(link, "box", (SIDE, SIDE, SIDE)), np.array([SIDE / 2, SIDE / 2, -SIDE / 2])
        solid, size = "box", 3 * [SIDE / 2]
    else:
        spec, at = ObjectSpec(link, "cylinder", (RADIUS, LENGTH)), np.array([0.0, 0.0, LENGTH / 2])
        solid, size = "cylinder", [RADIUS, LENGTH / 2]
    mesh = primitive(spec)
    text = _FIXED.format(link=link, solid=solid, at=_told(at), size=_told(size))
    body = Link(link, Mesh(mesh.vertices + at, mesh.faces))
    return Robot("ground", "made by formula", text, {}, (body,), (), np.zeros(0))


def _told(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:g}" for number in numbers)

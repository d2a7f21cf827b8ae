"""Speed and effort limits of a model in simulation: a lift that a finger presses down."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.maps.build import build_map
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.scene import Scene
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.generated_robots import load, model

pytestmark = pytest.mark.long

SPEED = 0.03
"""Largest speed of the lift [m/s]."""


def lift(effort: str, folder: Path) -> Robot:
    """A horizontal beam on a lift."""
    beam = (
        '<body name="beam"><joint name="lift" type="slide" axis="0 0 1" range="-0.5 0.5" damping="50"/>'
        '<geom type="capsule" size="0.05" fromto="0 0 0 0.5 0 0" mass="3"/></body>'
    )
    actuators = f'<actuator><velocity joint="lift" kv="1" ctrlrange="-{SPEED} {SPEED}" {effort}/></actuator>'
    return load(model(beam, extra=actuators), folder)


@cache
def prepared(effort: str, folder: Path) -> PreparedScene:
    robot = lift(effort, folder)
    skin = cover_robot(robot, CoverSpec(links=("beam",), taxels=80))
    return PreparedScene(Scene(name="lift", robot="lift"), robot, skin, build_map(skin))


def pressed(controller: str, effort: str, folder: Path, *, seconds: float = 1.5) -> tuple[np.ndarray, set[LimitKind]]:
    """Speeds of the lift [m/s] while a finger presses it down, and the limits that are reported."""
    scene = prepared(effort, folder)
    session = Session(scene)
    skin = scene.skin
    session.submit(ControlChanged(ControlSettings(controller=controller, force_gain=0.02, force_goal=1.0)))
    normals = np.array([skin.normal(skin.taxel_point(taxel)) for taxel in range(len(skin))])
    session.submit(PokePressed(1, skin.taxel_point(int(np.argmax(normals[:, 2]))), Finger(speed=0.1, max_force=30.0)))
    speeds = []
    kinds = set[LimitKind]()
    for _ in range(round(seconds / scene.scene.tick)):
        frame = session.tick()
        speeds.append(frame.velocity[0])
        kinds |= {limit.kind for limit in frame.why_limited}
    return np.array(speeds), kinds


@pytest.mark.long
@pytest.mark.parametrize("controller", ["hold_force", "hybrid", "qp"])
def test_lift_moves_no_faster_than_its_model_allows(controller, tmp_path):
    """The desired posture keeps the limit exactly; the lift follows it within 2 %. The finger comes at 0.1 m/s."""
    speeds, kinds = pressed(controller, "", tmp_path)
    assert 0.9 * SPEED < np.abs(speeds).max() < 1.02 * SPEED
    assert LimitKind.TORQUE_LIMIT not in kinds


@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", ["admittance", "qp"])
def test_lift_that_is_too_weak_yields_and_is_reported(controller, tmp_path):
    speeds, kinds = pressed(controller, 'forcerange="-2 2"', tmp_path)
    assert np.abs(speeds).max() > 0.09
    assert LimitKind.TORQUE_LIMIT in kinds

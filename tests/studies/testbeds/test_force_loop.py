"""The force loop of a whole arm: predicted from all its joints, and found where it was predicted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SkinError
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.loop_laws.gantry import gantry
from tactile_maps.studies.testbeds.fixed_ball import BALL, with_fixed_ball
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    ForceLoop,
    contact_stiffness,
    controller_filter,
    force_loop_at_goal,
    predicted_gain_limit,
    settled_session,
)
from tactile_maps.studies.testbeds.path_following import PathSetup, TrueContact
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.pressed_arm import forearm

CALM = ControlSettings(controller="hybrid", task="hold_point", force_gain=0.002)


@cache
def setup():
    return PathSetup(with_fixed_ball(forearm()))


@cache
def loop():
    return force_loop_at_goal(setup(), CALM)


@pytest.mark.long
def test_force_loop_is_linear_about_the_goal():
    session = settled_session(setup(), CALM)
    assert session.total_normal_force == pytest.approx(3.0, abs=0.1)
    made = loop()
    assert made.outward @ made.push == pytest.approx(1.0)
    assert np.abs(np.linalg.eigvals(made.moved[:14, :14])).max() < 1, "without a controller it comes to rest"


@pytest.mark.long
def test_contact_stiffness_equals_force_over_penetration():
    """Two goals: how much deeper the ball is then in the skin, found by the nearest point of its triangles."""
    forces = []
    depths = []
    for goal in (2.8, 3.2):
        session = settled_session(setup(), replace(CALM, force_goal=goal))
        ball = session.frame.objects[0, :3, 3]
        truth = TrueContact(setup().prepared.robot, setup().prepared.skin, setup().map)
        truth.error(session.frame.regions[0].at, ball, session.frame.posture)
        depths.append(BALL - float(np.linalg.norm(ball - truth.touched(ball))))
        forces.append(session.total_normal_force)
    found = (forces[1] - forces[0]) / (depths[1] - depths[0])
    assert loop().stiffness == pytest.approx(found, rel=0.05)  # the springs are at points, so it is not quite even
    flat = 2 * np.sqrt(np.pi * setup().prepared.scene.layer.foundation * BALL * 3.0)
    assert loop().stiffness < flat, "the forearm is bent: a ball on a plane would be stiffer"


@pytest.mark.long
def test_stiffness_of_a_ball_on_a_plane_matches_a_bed_of_springs():
    """F = pi K (R - d) d²: every spring pushes along the ball's radius; pi K R d² where it is not deep (Winkler)."""
    made = gantry()
    layer = ElasticLayer()
    deep = 0.001
    ball = ObjectSpec("ball", "sphere", (BALL,), at=(0.0, 0.0, BALL - deep), friction=0.0)
    scene = Scene("plate", "gantry", objects=(ball,), layer=layer, overrides={"skin": "foundation"}, outputs=("force",))
    plate = PathSetup(PreparedScene(scene, made.robot, made.skin, made.map, make_objects(scene)))
    found = contact_stiffness(plate, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    assert found == pytest.approx(np.pi * layer.foundation * deep * (2 * BALL - 3 * deep), rel=0.01)


def test_controller_equals_its_linear_filter():
    assert controller_filter(replace(CALM, controller="qp")) == Filter(0.002, integral_time=0.3)
    assert controller_filter(replace(CALM, controller="admittance")) == Filter(0.002, inertia_time=0.05)
    assert controller_filter(replace(CALM, controller="parallel")) == Filter(
        0.002, 0.3, position_gain=4.0, inertia_time=0.05
    )


@pytest.mark.parametrize("relaxation", [0.0, 1e-3])
def test_damping_of_the_layer_raises_the_gain_limit_as_by_routh(relaxation):
    """s (s² + a s + b) + g k w² (1 + T s) of a unit mass, with a = 2 w + k T and b = w² + k."""
    servo = 40.0
    stiffness = 5e3
    one = np.ones(1)
    made = ForceLoop.of_joints(
        1e-4,
        np.eye(1),
        servo**2 * one,
        2 * servo * one,
        stiffness,
        one,
        one,
        averaged=False,
        relaxation=relaxation,
    )
    damping = 2 * servo + stiffness * relaxation
    limit = damping * (servo**2 + stiffness) / (stiffness * servo**2 * (1 - relaxation * damping))
    assert predicted_gain_limit(made, replace(CALM, integral_time=np.inf)) == pytest.approx(limit, rel=0.01)


@pytest.mark.long
def test_lagging_controllers_have_smaller_gain_limits():
    gains = [
        predicted_gain_limit(loop(), replace(CALM, controller=controller))
        for controller in ("hybrid", "admittance", "parallel")
    ]
    assert gains == sorted(gains, reverse=True)
    quicker = predicted_gain_limit(loop(), replace(CALM, controller="admittance", inertia_time=0.01))
    assert gains[0] > quicker > gains[1]


@pytest.mark.long
def test_force_loop_without_contact_is_rejected():
    away = PathSetup(with_fixed_ball(forearm(), depth=-0.2))
    with pytest.raises(SkinError, match="no contact with the skin"):
        force_loop_at_goal(away, CALM)

"""Safety stops of the simulated arm: what stops it, and how it moves afterwards."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.control.task_control.monitors import QUIET, STOP_SPEED, YIELD_SPEED
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Sampling
from tests.support.pressed_arm import TICK, forearm, place_of
from tests.support.touch import arm

TAXEL = 150


def velocities_after_stop(controller: str, *, gravity: str) -> np.ndarray:
    """Return the joint velocities (k, n) of an arm that a finger has stopped and presses for 3 s."""
    effects = replace(RuntimeSettings.of_scene(arm()).effects, gravity=gravity)
    session = Session(
        arm(), scripted=False, settings=ControlSettings(controller=controller, stiffness=40.0), effects=effects
    )
    session.submit(PokePressed(1, arm().skin.taxel_point(TAXEL), Finger(speed=2.0, max_force=200.0)))
    velocities = []
    stopped = False
    for _ in range(600):
        frame = session.tick()
        stopped = stopped or any(limit.kind.stops for limit in frame.why_limited)
        if stopped:
            velocities.append(frame.velocity)
    assert stopped
    return np.array(velocities)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", ["impedance", "hold_force", "hybrid"])
@pytest.mark.parametrize("gravity", ["compensated", "on"])
def test_stopped_arm_yields_to_gravity_and_a_finger_at_a_bounded_speed(controller, gravity):
    """A finger of 200 N moves the arm at up to 2.3 rad/s where only the soft impedance holds it."""
    velocities = velocities_after_stop(controller, gravity=gravity)
    assert np.abs(velocities).max() < STOP_SPEED / 2
    assert np.abs(velocities).max() > 0.25 * YIELD_SPEED, "it does give way"


UNMEASURED = LimitKind.STOPPED_BY_UNMEASURED_FORCE


def session_with_probe_on_bare_hand(controller: str, force: float) -> Session:
    """An arm with skin on its forearm only; a ball comes from the side and pushes the hand for 2 s with ``force``."""
    prepared = forearm()
    mesh = prepared.robot.link("hand").mesh
    pose = Configuration(prepared.robot).pose("hand")
    points = pose.points(mesh.vertices)
    start = points[points[:, 1].argmax()] + [0.0, 0.03, 0.0]
    end = start - [0.0, 0.3, 0.0]
    path = ((0.0, *start), (0.2, *start), (2.2, *end), (2.3, *start), (60.0, *start))
    probe = ObjectSpec("probe", "probe", size=(0.02,), mass=0.2, friction=0.3, max_force=force, path=path)
    scene = replace(prepared.scene, objects=(probe,))
    prepared = replace(prepared, scene=scene, objects=make_objects(scene))
    effects = replace(RuntimeSettings.of_scene(prepared).effects, contact="environment", friction=True)
    settings = ControlSettings(controller=controller, stiffness=20.0)
    return Session(prepared, scripted=False, settings=settings, effects=effects)


def true_contact_force(session: Session) -> float:
    """Sum of the normal contact forces of the solver [N]; the probe touches nothing but the arm."""
    data = session._simulation._physics.data
    wrench = np.zeros(6)
    total = 0.0
    for contact in range(data.ncon):
        mujoco.mj_contactForce(session._simulation._physics.model, data, contact, wrench)
        total += float(wrench[0])
    return total


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", CHOICES["controller"])
def test_force_on_a_bare_link_stops_every_controller_while_it_lasts(controller):
    session = session_with_probe_on_bare_hand(controller, 60.0)
    above = 0
    first = None
    released = None
    for tick in range(1200):
        frame = session.tick()
        force = true_contact_force(session)
        assert not frame.regions, "the skin reads nothing"
        stops = [limit for limit in frame.why_limited if limit.kind.stops]
        above += force > 40.0
        if stops and first is None:
            first = stops[0]
        if force > 0:
            released = tick
        if first is not None and force > 5.0:
            assert [limit.kind for limit in stops] == [UNMEASURED], "it stays stopped while something presses"
    assert first is not None
    assert (first.kind, first.names, first.bound) == (UNMEASURED, ("hand",), 40.0)
    assert above * TICK <= 0.02, "the stop is not late, and a stopped arm gives way"
    assert not stops
    assert released < 1200 - QUIET / TICK


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", CHOICES["controller"])
def test_force_on_a_bare_link_below_the_largest_force_stops_no_controller(controller):
    session = session_with_probe_on_bare_hand(controller, 30.0)
    greatest = 0.0
    for _ in range(450):
        frame = session.tick()
        greatest = max(greatest, true_contact_force(session))
        assert not any(limit.kind.stops for limit in frame.why_limited)
    assert greatest > 15.0


def session_with_post_at_bare_hand(controller: str) -> Session:
    """An arm with skin on its forearm only: a ball touches the skin, and on the same side a post blocks the hand."""
    prepared = forearm()
    at = prepared.skin.taxel_point(TAXEL)
    configuration = Configuration(prepared.robot)
    outward = configuration.pose("forearm").directions(prepared.skin.normal(at))
    hand = configuration.pose("hand").points(prepared.robot.link("hand").mesh.vertices)
    blocked = hand[(hand @ outward).argmax()] + 0.022 * outward
    objects = (
        ObjectSpec("ball", "sphere", (0.02,), at=tuple(place_of(TAXEL, 0.0195)), friction=0.0),
        ObjectSpec("post", "sphere", (0.02,), at=tuple(blocked), friction=0.0),
    )
    layer = replace(prepared.scene.layer, stiffness=2e3)
    scene = replace(prepared.scene, objects=objects, layer=layer)
    prepared = replace(prepared, scene=scene, objects=make_objects(scene))
    effects = replace(RuntimeSettings.of_scene(prepared).effects, contact="environment")
    return Session(prepared, scripted=False, settings=ControlSettings(controller=controller), effects=effects)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", [name for name in CHOICES["controller"] if name != "impedance"])
def test_bare_link_that_the_force_loop_presses_on_a_post_is_named(controller):
    session = session_with_post_at_bare_hand(controller)
    for _ in range(500):
        frame = session.tick()
    (limit,) = (one for one in frame.why_limited if one.kind is LimitKind.UNMEASURED_FORCE)
    on_post = true_contact_force(session) - session.total_normal_force
    assert limit.names == ("hand",)
    assert limit.value == pytest.approx(on_post, rel=0.35)
    assert on_post > 5.0


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("integrator", ["implicitfast", "implicit", "discrete", "euler"])
@pytest.mark.parametrize("gravity", ["off", "on", "compensated"])
def test_external_torque_equals_that_of_the_applied_force(integrator, gravity):
    """The arm moves: 20 N push its hand, and it sags where gravity acts."""
    effects = replace(RuntimeSettings.of_scene(forearm()).effects, integrator=integrator, gravity=gravity)
    session = Session(forearm(), scripted=False, settings=ControlSettings(stiffness=6.0), effects=effects)
    model = session._simulation._physics.model
    data = session._simulation._physics.data
    hand = model.body("hand").id
    force = np.array([5.0, -15.0, 12.0])
    fastest = 0.0
    for tick in range(200):
        data.xfrc_applied[hand, :3] = force if tick >= 20 else 0.0
        frame = session.tick()
        fastest = max(fastest, float(np.abs(frame.velocity).max()))
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacobian, None, data.xipos[hand], hand)
        if tick > 60:
            found = session._controller._unmeasured._external
            assert found == pytest.approx(jacobian.T @ force, abs=0.1)
        elif tick < 20:
            assert np.abs(session._controller._unmeasured._external).max() < 0.1
    assert fastest > 0.3


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", ["impedance", "hold_force", "hybrid", "qp"])
@pytest.mark.parametrize(
    "sampling", [None, Sampling(50.0, 0.02), Sampling(10.0, 0.1)], ids=["200 Hz", "50 Hz", "10 Hz"]
)
def test_impacts_on_the_skin_do_not_count_as_unmeasured_force(controller, sampling):
    effects = RuntimeSettings.of_scene(arm()).effects
    effects = replace(effects, sensor=replace(effects.sensor, sampling=sampling))
    settings = ControlSettings(controller=controller, max_force=60.0)
    session = Session(arm(), scripted=False, settings=settings, effects=effects)
    greatest = 0.0
    for tick in range(450):
        if tick % 150 == 10:
            taxel = (TAXEL + 40 * tick) % len(arm().skin)
            session.submit(PokePressed(1, arm().skin.taxel_point(taxel), Finger(speed=1.0, max_force=50.0)))
        if tick % 150 == 100:
            session.submit(PokeReleased(1))
        frame = session.tick()
        greatest = max(greatest, session.total_normal_force)
        assert UNMEASURED not in {limit.kind for limit in frame.why_limited}
    assert greatest > 40.0


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("speed", "most"), [(0.05, 0.3), (0.1, 0.5), (0.2, 0.8)])
def test_quadratic_program_stays_below_80_percent_of_the_largest_force_in_slow_approaches(speed, most):
    """The guide's table; at 0.4 m/s the impact exceeds the greatest force."""
    session = Session(forearm(), scripted=False, settings=ControlSettings(controller="qp", max_force=40.0))
    session.submit(PokePressed(1, forearm().skin.taxel_point(TAXEL), Finger(speed=speed, max_force=120.0)))
    forces = []
    for _ in range(round(0.1 / speed / TICK) + 80):
        frame = session.tick()
        forces.append(session.total_normal_force)
        assert not any(limit.kind.stops for limit in frame.why_limited)
    assert 3.0 < max(forces) < most * 40.0

"""Control of robots that nothing was tuned for, judged by the forces and places of the simulation.

A few trials on generated robots run by default. Known faults are strict expected failures with the measured figure.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

from tactile_maps.control.motion.approach_speed import peak_force
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import posture_loop
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.session.inputs import RestChanged
from tactile_maps.session.session import Session
from tactile_maps.simulation.model.contact_stiffness import SOLVER_IMPEDANCE
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.studies.base.rows import distinct
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests import robots_page
from tests.control.robots.robot_models import BY_NAME
from tests.control.robots.robot_trials import Place, Posture, Trial, at_posture, posture_of, run

DEFAULT = [
    ("small arm", Trial("home", 1e5, 200.0, "hybrid", "press")),
    ("small arm", Trial("bent", 1e4, 50.0, "projection", "press")),
    ("medium arm", Trial("near singular", 1e4, 200.0, "admittance", "press")),
    ("medium arm", Trial("bent", 1e5, 200.0, "parallel", "press")),
    ("medium arm", Trial("bent", 1e4, 50.0, "projection", "path")),
    ("medium arm", Trial("home", 1e4, 50.0, "parallel", "press")),
    ("small arm", Trial("home", 1e3, 200.0, "admittance", "path")),
    ("small arm", Trial("bent", 1e4, 50.0, "hybrid", "path")),
    ("large arm", Trial("near limits", 1e3, 200.0, "hold_force", "press")),
    ("finger", Trial("bent", 1e4, 200.0, "priority", "press")),
    ("finger", Trial("home", 1e5, 50.0, "qp", "press")),
    ("finger", Trial("near singular", 1e3, 50.0, "admittance", "press")),
    ("finger", Trial("near limits", 1e4, 200.0, "priority", "press")),
    ("finger", Trial("home", 1e3, 200.0, "parallel", "press")),
    ("leg", Trial("bent", 1e5, 200.0, "qp", "press")),
    ("leg", Trial("home", 1e4, 200.0, "impedance", "pushed")),
    ("leg", Trial("near limits", 1e4, 200.0, "hold_force", "pushed")),
    ("leg", Trial("home", 1e3, 200.0, "parallel", "path")),
    ("arm", Trial("home", 1e3, 200.0, "projection", "pushed")),
]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Return the place at which a robot is pressed at a posture; each is made once."""
    folder = tmp_path_factory.mktemp("robots")

    @cache
    def prepared(name: str):
        return BY_NAME[name].prepare(folder)

    @cache
    def found(name: str, posture: Posture) -> Place:
        robot = prepared(name)
        joints = posture_of(robot, posture)
        assert joints is not None, "a posture without contact of links"
        return Place(at_posture(robot, joints))

    return found


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("name", "trial"), DEFAULT, ids=lambda value: str(value).replace(" ", "-"))
def test_robots_perform_their_task(place, name, trial):
    outcome = run(place(name, trial.posture), trial)
    assert outcome.tilt_deg > 15, "the place can be pressed"
    assert outcome.verdict == "ok", outcome


def test_finger_with_soft_joints_keeps_to_its_path(place):
    """Friction bends its joints by 10 to 20 mm along the skin."""
    outcome = run(place("finger", "home"), Trial("home", 1e3, 200.0, "projection", "path"), seconds=5.0)
    assert outcome.verdict == "ok", outcome


@pytest.mark.long
@pytest.mark.parametrize("name", distinct(robots_page.rows(), "robot"))
def test_robots_perform_as_stated_in_the_guide(place, name):
    """Failures are listed in the guide: one that is gone is as much a difference as a new one."""
    if BY_NAME[name].missing():
        pytest.skip(BY_NAME[name].missing())
    changed = {}
    for row in robots_page.rows():
        if row["robot"] != name or row["verdict"] == robots_page.NO_PLACE:
            continue
        trial = robots_page.trial_of(row)
        outcome = run(place(name, trial.posture), trial)
        if outcome.verdict != row["verdict"]:
            changed[str(trial)] = row["cause"], outcome
    assert not changed


@pytest.mark.parametrize("goal", ["press", "limit cycle", "overload", "truth", "path"])
def test_goals_are_reached_over_all_robots(goal):
    met, text, reached = robots_page.goals(robots_page.rows())[goal]
    assert met, f"{text}: {reached}"


def predicted_peak(mobility: float, estimated: float, stiffness: float, speed: float, step: float) -> float:
    """Return the greatest force of an impact [N], by ``tactile_maps.simulation.model.contact_stiffness``.

    Two bodies that nothing else accelerates: depth'' = -A f with f = (K depth + B depth') / (w + A), by steps.

    Args:
        mobility: A, the sum of the inverse masses of both bodies along the normal [1/kg].
        estimated: w, the same as MuJoCo estimates it [1/kg].
        stiffness: Stiffness of the cover [N/m].
        speed: Speed before the impact [m/s].
        step: Time step of the simulation [s].
    """
    spring = stiffness * (1 - SOLVER_IMPEDANCE) * estimated
    damping = 2 * np.sqrt(spring) / SOLVER_IMPEDANCE
    depth = 0.0
    peak = 0.0
    while speed > 0:
        force = (spring / SOLVER_IMPEDANCE * depth + damping * speed) / (estimated + mobility)
        peak = max(peak, force)
        speed -= step * mobility * force
        depth += step * speed
        if force < 0.5 * peak:
            break
    return peak


@pytest.mark.sampled(2)
@pytest.mark.parametrize("stiffness", [1e4, 1e5])
@pytest.mark.parametrize("name", ["small arm", "medium arm", "large arm", "leg"])
def test_peak_of_an_impact_follows_from_the_masses(place, name, stiffness):
    """A ball of 0.5 kg at 0.2 m/s without friction. One step is one tick, so that a reading is no mean of several."""
    at = place(name, "home")
    speed = 0.2
    mass = 0.5
    step = 0.00025
    layer = replace(at.prepared.scene.layer, stiffness=stiffness, friction=0.0)
    assert isinstance(layer, ElasticLayer)
    scene = at.with_ball(layer, depth=at.gap - 2e-4)
    (ball,) = scene.scene.objects
    fine = {**scene.scene.overrides, "timestep": step}
    falling = replace(scene.scene, objects=(replace(ball, mass=mass),), tick=step, overrides=fine)
    session = Session(replace(scene, scene=falling, objects=make_objects(falling)), settings=ControlSettings())
    assert session.effects.timestep == step
    model = session._simulation._model
    data = session._simulation._data
    body = model.body(body_name(ball))
    joint = int(model.jnt_dofadr[body.jntadr[0]])
    data.qvel[joint : joint + 3] = -speed * at.outward
    forces = []
    for _ in range(80):
        session.tick()
        forces.append(session.total_normal_force)
    assert forces[0] == 0 < max(forces), "the ball flies and then touches"
    link = model.body(at.link).id
    move = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, move, None, data.xpos[body.id] - at.radius * at.outward, link)
    along = move.T @ at.outward
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    mobility = 1 / mass + float(along @ np.linalg.solve(inertia, along))
    estimated = float(model.body_invweight0[link, 0] + model.body_invweight0[body.id, 0])
    assert max(forces) == pytest.approx(predicted_peak(mobility, estimated, stiffness, speed, step), rel=0.2)


_APPROACHES = [
    ("medium arm", 2e3, 3.0, 0.010),
    ("medium arm", 1e4, 4.0, 0.006),
    ("medium arm", 1e5, 4.0, 0.006),
    ("medium arm", 1e5, 15.0, 0.020),
    ("large arm", 2e3, 4.0, 0.006),
    ("large arm", 2e3, 30.0, 0.020),
    ("large arm", 1e4, 30.0, 0.020),
    ("large arm", 1e5, 4.0, 0.003),
    ("large arm", 1e5, 30.0, 0.010),
    ("leg", 2e3, 2.0, 0.010),
    ("leg", 1e4, 4.0, 0.006),
    ("leg", 1e5, 15.0, 0.020),
    ("arm", 2e3, 20.0, 0.020),
    ("arm", 1e4, 4.0, 0.003),
    ("arm", 1e4, 30.0, 0.020),
    ("arm", 1e5, 30.0, 0.010),
]
"""Robot, stiffness of the cover [N/m], largest impact [N], and distance of the ball at the start [m]."""
_QUICK = (11,)


@pytest.mark.parametrize(
    ("name", "stiffness", "max_impact", "distance"),
    [pytest.param(*case, marks=() if k in _QUICK else pytest.mark.long) for k, case in enumerate(_APPROACHES)],
)
def test_limited_approach_hits_as_hard_as_predicted(place, name, stiffness, max_impact, distance):
    """The arm moves into a fixed ball without friction. One step is one tick, so that a force is no mean of several."""
    at = place(name, "home")
    step = 0.0005
    robot = at.prepared.robot
    layer = replace(at.prepared.scene.layer, stiffness=stiffness, friction=0.0)
    scene = at.with_ball(layer, depth=at.gap - distance)
    fine = replace(scene.scene, tick=step, overrides={**scene.scene.overrides, "timestep": step})
    settings = ControlSettings("hold_force", max_impact=max_impact, max_force=200.0)
    session = Session(replace(scene, scene=fine, objects=make_objects(fine)), settings=settings)
    configuration = Configuration(robot)
    position = at.prepared.skin.position(at.prepared.skin.taxel_point(at.taxel))
    move = configuration.jacobian(at.link, position)
    way = np.linalg.pinv(move) @ at.outward
    lower = [joint.lower for joint in robot.joints]
    upper = [joint.upper for joint in robot.joints]
    beyond = np.clip(robot.home + 0.4 * way / np.abs(way).max(), lower, upper)
    session.submit(RestChanged(tuple(beyond.tolist()), speed=None))
    frame = session.frame
    while session.total_normal_force == 0:
        before = frame
        frame = session.tick()
        assert frame.time < 4.0, "the arm arrives"
    assert LimitKind.APPROACH_SPEED in [limit.kind for limit in before.why_limited]
    forces = [session.total_normal_force]
    for _ in range(100):
        session.tick()
        forces.append(session.total_normal_force)
    configuration.update(before.posture)
    outward = at.outward @ configuration.jacobian(at.link, position)
    impedance = posture_loop(configuration)
    predicted = peak_force(
        configuration.mass_matrix(),
        (impedance.stiffness, impedance.damping),
        outward,
        before.velocity,
        stiffness=stiffness,
        latency=step,
    )
    assert max(forces) == pytest.approx(predicted, rel=0.2)
    assert max(forces) < 1.2 * max_impact

"""Changing effects while it runs: the state stays, what is off leaves, and it is the same every time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import SimulationError
from app.scene.effects import Effects
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.touch.sensor.area_averaging import AreaAveraging
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.hysteresis import Hysteresis
from app.touch.sensor.noise import Noise
from tests.things import thing
from tests.touch import arm, bar, bar_skin, hold

PRESS = PokePressed(1, bar_skin().taxel_point(30), Finger(max_force=3.0))
OTHERS = (
    Effects(gravity="off"), Effects(contact="environment"), Effects(contact="self"), Effects(contact="all"),
    Effects(joint_limits=False), Effects(timestep=5e-4), Effects(fingers=True, friction=True), Effects(skin="off"),
    Effects(joint_friction=True), Effects(skin="depth", contact="all"), Effects(skin="foundation", contact="all"),
    Effects(integrator="discrete"), Effects(integrator="rk4"), Effects(sensor=SensorEffects(noise=Noise())),
    Effects(skin="point"),
)  # fmt: skip


def moving(*, effects: Effects | None = None, things=()) -> Simulation:
    simulation = Simulation(bar(), bar_skin(), effects or Effects(), objects=things)
    simulation.apply(PRESS)
    simulation.step(300, hold(bar(), 5.0, 0.5))
    assert abs(simulation.velocity[0]) > 1e-3
    return simulation


@pytest.mark.parametrize("other", OTHERS)
def test_there_and_back_the_state_is_bitwise_the_same(other):
    simulation = moving(things=(thing("box", at=(5.0, 0.0, 5.0), mass=1.0),))
    before = simulation.posture, simulation.velocity, simulation.time, simulation.pokes[0].force
    simulation.use(other)
    assert simulation.effects is other
    assert (simulation.posture, simulation.velocity, simulation.time, simulation.pokes[0].force) == before
    simulation.use(Effects())
    assert (simulation.posture, simulation.velocity, simulation.time, simulation.pokes[0].force) == before
    one, two = moving(things=(thing("box", at=(5.0, 0.0, 5.0), mass=1.0),)), simulation
    for run in (one, two):
        run.step(200, hold(bar(), 5.0, 0.5))
    assert np.array_equal(one.posture, two.posture), "and so is the future"
    assert np.array_equal(one.velocity, two.velocity)


def test_the_same_effects_change_nothing_at_all():
    simulation = moving()
    model, state, touch = simulation._model, simulation.state(), simulation._touch
    simulation.use(Effects())
    assert simulation._model is model
    assert simulation._touch is touch
    assert np.array_equal(simulation.state(), state)


def test_sensor_and_skin_model_leave_the_physics_alone():
    simulation = moving()
    model = simulation._model
    for effects in (Effects(sensor=SensorEffects(noise=Noise())), Effects(skin="point"), Effects(skin="off")):
        simulation.use(effects)
        assert simulation._model is model


def test_live_changes_are_the_same_every_time():
    def run() -> list[np.ndarray]:
        prepared, states = arm(), []
        simulation = Simulation(prepared.robot, prepared.skin, Effects(), objects=(thing("plane", at=(0, 0, -1)),))
        simulation.apply(PokePressed(1, prepared.skin.taxel_point(150), Finger(max_force=5.0)))
        for effects in (
            Effects(contact="self"),
            Effects(gravity="on"),
            Effects(contact="all", friction=True),
            Effects(),
        ):
            simulation.use(effects)
            simulation.step(30, hold(prepared.robot, 3.0, 0.5))
            states += [simulation.state(), simulation.sense()]
        return states

    for one, other in zip(run(), run(), strict=True):
        assert np.array_equal(one, other)


def test_an_object_that_leaves_stands_still_until_it_comes_back():
    ball, on, off = thing("sphere", at=(5.0, 0.0, 20.0), mass=1.0), Effects(contact="environment"), Effects()
    simulation = Simulation(bar(), bar_skin(), on, objects=(ball,))
    simulation.step(500, hold(bar(), 1.0, 1.0))
    fallen = simulation.object_poses
    assert fallen[0, 2, 3] < 19.0
    simulation.use(off)
    assert np.array_equal(simulation.object_poses, fallen)
    simulation.step(500, hold(bar(), 1.0, 1.0))
    assert np.array_equal(simulation.object_poses, fallen), "what is off does not fall"
    simulation.use(on)
    assert np.array_equal(simulation.object_poses, fallen)
    simulation.step(100, hold(bar(), 1.0, 1.0))
    assert fallen[0, 2, 3] - simulation.object_poses[0, 2, 3] == pytest.approx(0.5 * 9.81 * 0.01, rel=0.02), "from rest"
    simulation.reset()
    assert simulation.object_poses[0, 2, 3] == 20.0


def test_a_falling_object_goes_on_falling_when_something_else_changes():
    ball = thing("sphere", at=(5.0, 0.0, 20.0), mass=1.0)
    one, two = (Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,)) for _ in range(2))
    for run in (one, two):
        run.step(100, hold(bar(), 1.0, 1.0))
    two.use(Effects(contact="environment", joint_limits=False))
    for run in (one, two):
        run.step(100, hold(bar(), 1.0, 1.0))
    assert np.array_equal(one.object_poses, two.object_poses)


def test_objects_that_were_never_in_the_physics_are_shown_where_the_scene_has_them():
    box, probe = thing("box", at=(1.0, 2.0, 3.0), turn=(0, 0, 90)), thing("probe", path=((0.0, 4.0, 5.0, 6.0),))
    simulation = Simulation(bar(), bar_skin(), Effects(), objects=(box, probe))
    assert simulation.object_poses[0] == pytest.approx(box.spec.pose.matrix)
    assert simulation.object_poses[1, :3, 3] == pytest.approx((4, 5, 6))
    assert Simulation(bar(), bar_skin(), Effects()).object_poses.shape == (0, 4, 4)


def test_fingers_off_lifts_them_and_refuses_new_ones():
    simulation = moving()
    simulation.use(Effects(fingers=False))
    assert simulation.pokes == ()
    before = simulation.state()
    simulation.apply(PokeReleased(1))
    simulation.apply(PokeMoved(1, PRESS.at))
    assert np.array_equal(simulation.state(), before)
    with pytest.raises(SimulationError, match="nobody can poke"):
        simulation.apply(PRESS)
    simulation.step(1, hold(bar(), 1.0, 1.0))
    assert not simulation._data.qfrc_applied.any(), "its force is gone with it"


def test_a_finger_too_stiff_for_the_new_step_is_refused_and_nothing_changes():
    simulation = Simulation(bar(), bar_skin(), Effects())
    simulation.apply(PokePressed(1, bar_skin().taxel_point(30), Finger(stiffness=1e5)))
    before, model = simulation.state(), simulation._model
    with pytest.raises(SimulationError, match="too stiff"):
        simulation.use(Effects(timestep=8e-3))
    assert np.array_equal(simulation.state(), before)
    assert simulation._model is model
    assert simulation.effects == Effects()
    simulation.step(10, hold(bar(), 1.0, 1.0))


def test_the_sensor_keeps_what_it_can():
    creep = SensorEffects(hysteresis=Hysteresis())
    simulation = moving(effects=Effects(sensor=creep))
    simulation.sense()
    state = simulation._chain.state()
    assert state.any()
    simulation.use(Effects(sensor=replace(creep, noise=Noise()), contact="self"))
    assert [name for name, _ in simulation.readings] == ["touch", "hysteresis", "noise"]
    assert np.array_equal(simulation._chain.state()[: len(state)], state)


def test_what_is_off_leaves_no_stage_and_no_chain():
    simulation = moving()
    assert [name for name, _ in simulation.readings] == ["touch"]
    assert simulation._chain is None
    simulation.use(Effects(skin="off", sensor=SensorEffects(noise=Noise())))
    assert simulation.readings == ()
    assert simulation._chain is None
    assert not simulation.sense().any()
    assert simulation.notes == ()


def test_area_averaging_changes_what_the_taxels_feel():
    simulation = moving()
    whole = simulation.sense()
    simulation.use(Effects(sensor=SensorEffects(area_averaging=AreaAveraging())))
    assert simulation._chain is None, "it is no stage"
    assert not np.array_equal(simulation.sense(), whole)


def test_readings_called_in_turn_are_what_sense_gives():
    effects = Effects(sensor=SensorEffects(hysteresis=Hysteresis(), noise=Noise()))
    one, two = moving(effects=effects), moving(effects=effects)
    pressures = np.zeros(len(bar_skin()))
    for _, read in one.readings:
        pressures = read(pressures)
    assert np.array_equal(pressures, two.sense())
    assert np.array_equal(one.state(), two.state())


def test_a_reset_repeats_the_noise():
    simulation = moving(effects=Effects(sensor=SensorEffects(noise=Noise())))
    first = simulation.sense()
    simulation.reset()
    simulation.apply(PRESS)
    simulation.step(300, hold(bar(), 5.0, 0.5))
    assert np.array_equal(simulation.sense(), first)


def test_how_a_mesh_touches_is_noted():
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(thing("mesh", at=(5, 0, 0)),))
    assert simulation.notes == ("mesh touches as its convex hull",)
    simulation.use(Effects())
    assert simulation.notes == ()


@pytest.mark.parametrize("order", [("pokes", "object_poses"), ("object_poses", "pokes"), ()])
def test_asking_for_places_changes_no_number(order):
    """Kinematics are computed when asked for; who asks first must not matter."""
    ball = thing("sphere", at=(0.2, 0.0, 0.04), mass=0.2)
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,))
    simulation.apply(PRESS)
    seen = []
    for _ in range(60):
        simulation.step(5, hold(bar(), 50.0, 2.0))
        for name in order:
            getattr(simulation, name)
        seen.append(simulation.sense())
    assert np.any(seen[-1])
    reference = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,))
    reference.apply(PRESS)
    for pressures in seen:
        reference.step(5, hold(bar(), 50.0, 2.0))
        assert np.array_equal(reference.sense(), pressures)
    assert np.array_equal(reference.state(), simulation.state())

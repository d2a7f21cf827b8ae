"""Dragging with friction: a force that is held stays, contact is never lost, and Coulomb's law is obeyed."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from app.scene.effects import Effects
from app.simulation.object_geoms import LIGHTEST
from app.simulation.simulation import Simulation
from app.touch.layer import Layer
from tests.things import thing
from tests.touch import bar, bar_skin, hold

FORCE, MASS = 10.0, 0.2


def dragged(
    friction: float, speed: float, stiffness: float, *, hinged: bool = True, force: float = FORCE, **effects
) -> tuple[np.ndarray, np.ndarray]:
    """Normal and friction force [N] at each step while a probe presses with ``force`` and slides along the bar."""
    robot, top = bar(hinged=hinged), 0.02 + 0.01
    slides = 1.0 + 0.22 / speed
    path = ((0.0, 0.1, 0.0, top + 0.001), (0.1, 0.1, 0.0, top - 0.05), (1.0, 0.1, 0.0, top - 0.05),
            (slides, 0.32, 0.0, top - 0.05))  # fmt: skip
    probe = thing("probe", path=path, mass=MASS, max_force=force, friction=friction)
    layer = Layer(stiffness=stiffness, friction=friction)
    simulation = Simulation(robot, bar_skin(), Effects(contact="probe", friction=True, **effects), objects=(probe,),
                            layer=layer)  # fmt: skip
    assert LIGHTEST < MASS
    command, rows, wrench = hold(robot, 2000.0, 80.0), [], np.zeros(6)
    simulation.step(round(1.3 / simulation.timestep), command)
    while simulation.time < min(slides - 0.01, 4.0):
        simulation.step(1, command)
        wrench[:] = 0
        if simulation._data.ncon:
            mujoco.mj_contactForce(simulation._model, simulation._data, 0, wrench)
        rows.append((wrench[0], np.hypot(wrench[1], wrench[2])))
    return tuple(np.array(rows).T)


@pytest.mark.parametrize("stiffness", [2e3, 2e4, 2e5])
@pytest.mark.parametrize("friction", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("speed", [0.03, 0.1])
def test_ten_newtons_are_held_while_sliding(stiffness, friction, speed):
    normal, tangent = dragged(friction, speed, stiffness)
    assert len(normal) > 500
    assert (normal > 0).all(), "never lost"
    assert np.abs(normal - FORCE).max() < 0.03 * FORCE
    assert (tangent <= friction * normal * (1 + 1e-6)).all()


@pytest.mark.parametrize(("friction", "speed"), [(0.2, 0.03), (0.2, 0.1), (0.5, 0.1), (0.5, 0.2), (1.0, 0.2)])
def test_what_slides_rubs_with_coulombs_force(friction, speed):
    """A cure for hopping that turns friction off is none: MuJoCo's ``solreffriction = 0.2 1`` leaves 1 % of it."""
    normal, tangent = dragged(friction, speed, 2e4, hinged=False)
    steady = slice(len(normal) // 3, None)
    assert tangent[steady].mean() == pytest.approx(friction * normal[steady].mean(), rel=0.03)


@pytest.mark.parametrize("integrator", ["discrete", "euler", "implicit", "rk4"])
def test_with_every_integrator(integrator):
    for speed in (0.1, 0.2):
        normal, tangent = dragged(0.5, speed, 2e4, integrator=integrator)
        assert np.abs(normal - FORCE).max() < 0.03 * FORCE
        steady = slice(len(normal) // 3, None)
        assert tangent[steady].mean() == pytest.approx(0.5 * FORCE, rel=0.03)


@pytest.mark.parametrize("timestep", [5e-4, 2e-3])
def test_with_other_time_steps(timestep):
    normal, _ = dragged(0.5, 0.1, 2e4, timestep=timestep)
    assert np.abs(normal - FORCE).max() < 0.03 * FORCE


def test_without_friction_nothing_rubs():
    robot = bar()
    probe = thing("probe", path=((0.0, 0.1, 0.0, 0.029), (2.0, 0.3, 0.0, 0.029)), mass=MASS, friction=1.0)
    simulation = Simulation(robot, bar_skin(), Effects(contact="probe"), objects=(probe,))
    simulation.step(1000, hold(robot, 2000.0, 80.0))
    wrench = np.zeros(6)
    mujoco.mj_contactForce(simulation._model, simulation._data, 0, wrench)
    assert wrench[0] > 0.5
    assert not wrench[1:].any()

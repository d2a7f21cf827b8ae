"""A taxel reads no number in mid-contact: laws that read stand still and say so; no posture is no number."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.sense import ContactSense
from app.control.command import ControlSettings
from app.control.contact_motion import ContactMotionController
from app.control.reference import MAX_JOINT_SPEED
from app.simulation.simulation import Simulation
from tests.numerics.hard_control import GOAL
from tests.numerics.pressed_arm import TICK, beside_ball

BAD = {"one taxel": slice(150, 151), "all taxels": slice(None), "one far away": slice(0, 1)}
FAULT, MENDED, END = 1.0, 2.0, 5.0
"""When the skin breaks, when it is whole again, and when all is over [s]."""


class Run:
    """A session's loop by hand, with a fault in the wire between the skin and who reads it.

    Attributes:
        pressed: (k,) what truly presses [N].
        postures: (k, n).
        commanded: (k, n).
        said: (k,) why the controller was limited.
    """

    def __init__(self, law: str, where: slice, value: float) -> None:
        scene = beside_ball(ControlSettings()).prepared
        simulation = Simulation(scene.robot, scene.skin, scene.scene.effects, objects=scene.objects,
                                layer=scene.scene.layer, tick=TICK)  # fmt: skip
        sense = ContactSense(scene.robot, scene.map, scene.scene.effects.sensor)
        controller = ContactMotionController(scene.robot, ControlSettings(law=law, task="hold_point"), scene.map)
        rows, self.said = [], []
        for k in range(round(END / TICK)):
            pressures = simulation.sense().copy()
            if FAULT <= k * TICK < MENDED:
                pressures[where] = value
            regions = sense.read(k, k * TICK, simulation.posture, pressures)
            command = controller.command(simulation.posture, simulation.velocity, regions, TICK,
                                         readable=bool(np.isfinite(pressures).all()))  # fmt: skip
            rows.append((simulation.pressing, np.abs(simulation.velocity).max(), simulation.posture, command.posture))
            self.said.append(controller.why_limited)
            simulation.step(scene.scene.steps_per_tick, command)
        pressed, speed, postures, commanded = zip(*rows, strict=True)
        self.pressed, self.speed = np.array(pressed), np.array(speed)
        self.postures, self.commanded = np.array(postures), np.array(commanded)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.parametrize("where", BAD)
@pytest.mark.parametrize("law", ["hybrid", "qp", "hold_force"])
def test_the_arm_stands_while_the_skin_cannot_be_read(law, where, value):
    run = Run(law, BAD[where], value)
    broken = slice(round(FAULT / TICK), round(MENDED / TICK))
    assert np.isfinite(run.commanded).all()
    assert all(any("no number" in why for why in said) for said in run.said[broken])
    assert np.abs(run.postures[broken] - run.postures[broken][0]).max() < 0.02
    assert run.pressed.max() < 8.0
    assert run.speed.max() < MAX_JOINT_SPEED
    if law == "hold_force":  # without a supervisor: it goes on where it stood
        assert run.pressed[-1] == pytest.approx(GOAL, abs=0.1)
        assert run.said[-1] == ()
    else:  # it stopped, softly, and goes on when nothing has touched for a second
        later = run.said[round((MENDED + 0.5) / TICK)]
        assert later == ("stopped: the skin reads what is no number; lift what touches to go on",)


def test_a_law_that_reads_nothing_goes_on():
    run = Run("impedance", BAD["all taxels"], float("nan"))
    assert not any(run.said)
    assert np.isfinite(run.commanded).all()

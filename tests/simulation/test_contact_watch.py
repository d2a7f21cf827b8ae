"""Notes on contacts between two readings: too deep, too hard, or too short to be read; and on fast bodies."""

from __future__ import annotations

import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.contact_watch import DEEPEST, FASTEST, HARDEST
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold

INTEGRATORS = ("implicitfast", "euler")
RADIUS = 0.02
TOP = 0.02


def on_the_bar(depth: float, *, mass: float, stiffness: float = 2e4, **effects) -> Simulation:
    """Return a ball on a guide, pressed to ``depth`` into the top of a fixed bar."""
    ball = thing("sphere", size=(RADIUS,), at=(0.2, 0.0, TOP + RADIUS - depth), mass=mass, guided=True)
    expected = Effects(**{"contact": "environment", "gravity": "compensated", **effects})
    return Simulation(bar(hinged=False), bar_skin(), expected, objects=(ball,), layer=ElasticLayer(stiffness=stiffness))


def notes(simulation: Simulation, steps: int) -> list:
    simulation.step(steps, hold(bar(hinged=False), 0.0, 0.0))
    kinds = (ContactNoteKind.DEEP, ContactNoteKind.HARD, ContactNoteKind.FAST, ContactNoteKind.BRIEF)
    return [note for note in simulation.notes if note.kind in kinds]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_body_deeper_than_any_cover_is_noted_with_its_depth(integrator):
    assert notes(on_the_bar(0.9 * DEEPEST, mass=1.0, integrator=integrator), 5) == []
    (note,) = notes(on_the_bar(1.2 * DEEPEST, mass=1.0, integrator=integrator), 5)
    assert (note.kind, note.bodies) == (ContactNoteKind.DEEP, ("sphere", "bar"))
    assert note.depth == pytest.approx(0.012, rel=0.02)
    assert "sphere is deep in bar: 1" in contact_note_text(note)


def test_noted_depth_is_the_largest_between_two_readings():
    """A heavy ball on its way in: step by step it is deeper, and back."""
    one, many = (on_the_bar(0.0102, mass=1.0) for _ in range(2))
    for simulation in (one, many):
        simulation._data.qvel[0] = -2.0
        simulation._physics.forward()
    depths = [note.depth for _ in range(40) for note in notes(one, 1)]
    assert depths[0] < 0.97 * max(depths) > depths[-1], "in and out"
    (note,) = notes(many, 40)
    assert note.depth == max(depths)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_short_force_beyond_the_limit_is_noted(integrator):
    """4 mm at 5e6 N/m are 2e4 N, of a body that is pushed out half: over within a tick of 10 ms."""
    simulation = on_the_bar(0.004, mass=1.0, stiffness=5e6, integrator=integrator, timestep=0.0001)
    found = notes(simulation, 100)
    hard = next(note for note in found if note.kind is ContactNoteKind.HARD)
    assert HARDEST < 0.45 * 2e4 < hard.force < 1.01 * 2e4
    assert simulation.total_normal_force == 0, "nothing of it at the reading"
    soft = on_the_bar(0.0002, mass=1.0, stiffness=5e6, integrator=integrator, timestep=0.0001)
    assert all(note.kind is not ContactNoteKind.HARD for note in notes(soft, 100)), "a tenth of it"


def test_contact_between_two_readings_is_noted():
    simulation = on_the_bar(-0.001, mass=0.01, stiffness=2e5)
    simulation._data.qvel[0] = -1.0
    simulation._physics.forward()
    (note,) = notes(simulation, 20)
    assert (note.kind, note.bodies) == (ContactNoteKind.BRIEF, ("sphere", "bar"))
    assert simulation._data.qvel[0] > 0, "it has bounced"
    assert notes(simulation, 1) == [], "reported once"


def test_contact_present_in_a_reading_is_not_noted_as_brief():
    simulation = on_the_bar(0.001, mass=0.01, stiffness=2e5)
    assert notes(simulation, 1) == []
    assert simulation.total_normal_force > 0
    assert notes(simulation, 30) == [], "it ended, but it was read before"
    assert simulation.total_normal_force == 0


def test_short_contact_without_skin_is_not_noted():
    """Two balls meet away from the robot."""
    balls = [
        thing("sphere", name=f"ball {k}", at=(5.0, 0.0, 5.0 + 0.0395 * k), mass=0.1, guided=True) for k in range(2)
    ]
    simulation = Simulation(bar(hinged=False), bar_skin(), Effects(contact="environment"), objects=balls)
    simulation._data.qvel[-1] = 3.0
    assert notes(simulation, 20) == []


def thrown(mass: float, *, gap: float = 0.0002, integrator: str = "implicitfast") -> Simulation:
    """A ball that meets the bar at 0.5 m/s."""
    simulation = on_the_bar(-gap, mass=mass, integrator=integrator, timestep=0.001, gravity="off")
    simulation._data.qvel[0] = -0.5
    simulation._physics.forward()
    return simulation


def rebound(simulation: Simulation) -> float:
    """Speed after the contact as a share of that before it."""
    simulation.step(20, hold(bar(hinged=False), 0.0, 0.0))
    return float(simulation._data.qvel[0]) / 0.5


def test_implausibly_fast_body_is_noted_with_its_speed():
    simulation = on_the_bar(-0.01, mass=1.0, timestep=0.0001, gravity="off")
    simulation._data.qvel[0] = 1.2 * FASTEST
    simulation._physics.forward()
    (note,) = (note for note in notes(simulation, 20) if note.kind is ContactNoteKind.FAST)
    assert note.bodies == ("sphere",)
    assert note.speed == pytest.approx(1.2 * FASTEST, rel=1e-6)
    assert contact_note_text(note).startswith(f"sphere moves at {note.speed:.3g} m/s; ")


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("gap", [0.00001, 0.00017, 0.00033, 0.00049])
def test_bodies_rebound_no_faster_than_they_came(gap, integrator):
    """A contact gives no energy, at whatever depth it is found: free bodies lighter than K h^2 touch softer."""
    least = 2e4 * 0.001**2
    for mass in (least, 1.5 * least, 30.0 * least):
        simulation = thrown(mass, gap=gap, integrator=integrator)
        assert simulation.notes == ()
        assert abs(rebound(simulation)) < 1
    for mass in (0.9 * least, 0.1 * least, 1e-3 * least, 5e-5 * least):
        light = thrown(mass, gap=gap, integrator=integrator)
        assert any(note.kind is ContactNoteKind.SOFTER for note in light.notes)
        assert abs(rebound(light)) < 1
    assert abs(rebound(thrown(1e-6, gap=gap, integrator="discrete"))) < 1

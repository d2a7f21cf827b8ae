"""Stiffness of skin contacts: the solver's numbers, sharing among several points, and notes on unstable ones."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.contact_points import frame_along
from tactile_maps.simulation.model.contact_stiffness import (
    SOLVER_IMPEDANCE,
    ContactSharing,
    effective_count,
    unstable_contacts,
)
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.passive_friction import PassiveFriction
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.studies.testbeds.contact_bench import BODIES, STIFFNESS, bench, lay
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold

BOX = thing("box", at=(5.0, 0.0, 5.0), mass=1.0)


def test_solver_parameters_of_a_pair_follow_the_formula():
    layer = ElasticLayer(stiffness=5e4)
    model = assemble(bar(), bar_skin(), Effects(contact="environment", friction=True), objects=(BOX,), layer=layer)
    both = model.body("bar").invweight0[0] + model.body("tactile-maps/object box").invweight0[0]
    k, b = -model.pair_solref[0]
    assert k / ((1 - SOLVER_IMPEDANCE) * both) == pytest.approx(5e4)
    assert b == pytest.approx(2 * np.sqrt(k))
    assert model.pair_solimp[0, :2] == pytest.approx(SOLVER_IMPEDANCE)
    assert -model.pair_solreffriction[0, 1] / SOLVER_IMPEDANCE == pytest.approx(0.5 / model.opt.timestep)


def test_free_object_too_light_for_the_step_gets_softer_contact_and_a_note_with_a_remedy():
    """Its stiffness is that of a mass of K h^2; with the longest step of the note the stated stiffness is kept."""
    light = thing("sphere", at=(5.0, 0.0, 5.0), mass=0.002)
    soft = ElasticLayer(stiffness=1e3)
    stiff = ElasticLayer(stiffness=1e5)
    effects = Effects(contact="environment")
    assert unstable_contacts(assemble(bar(), bar_skin(), effects, objects=(light,), layer=soft), soft) == ()
    model = assemble(bar(), bar_skin(), effects, objects=(light,), layer=stiff)
    (note,) = unstable_contacts(model, stiff)
    assert (note.kind, note.bodies) == (ContactNoteKind.SOFTER, ("bar", "sphere"))
    assert "bar and sphere touch with 2e+03 N/m instead of 1e+05 N/m" in contact_note_text(note)
    mobility = model.body("bar").invweight0[0] + model.body("tactile-maps/object sphere").invweight0[0]
    assert note.max_stiffness == pytest.approx(1 / (mobility * effects.timestep**2))
    assert -model.pair_solref[0, 0] == pytest.approx((1 - SOLVER_IMPEDANCE) * mobility * note.max_stiffness)
    shorter = replace(effects, timestep=0.999 * note.max_timestep)
    assert unstable_contacts(assemble(bar(), bar_skin(), shorter, objects=(light,), layer=stiff), stiff) == ()
    discrete = assemble(bar(), bar_skin(), replace(effects, integrator="discrete"), objects=(light,), layer=stiff)
    assert unstable_contacts(discrete, stiff) == ()


def stiff_bar(integrator: str) -> Simulation:
    ball = thing("sphere", at=(0.3, 0.0, 0.0395))
    effects = Effects(contact="environment", integrator=integrator)
    return Simulation(bar(), bar_skin(), effects, objects=(ball,))


@pytest.mark.long
def test_result_of_integrator_discrete_does_not_depend_on_steps_per_call():
    one = stiff_bar("discrete")
    many = stiff_bar("discrete")
    command = hold(bar(), 2000.0, 50.0)
    many.step(60, command)
    for _ in range(60):
        one.step(1, command)
    assert np.array_equal(one.state(), many.state())


def test_contact_points_share_stiffness_by_depth():
    assert effective_count([1e-4]) == 1
    assert effective_count([1e-4] * 4) == pytest.approx(4)
    assert effective_count([1e-4, 0.0]) == 1
    assert effective_count([1e-4, -1e-5]) == 1
    assert effective_count([0.0, 0.0, 0.0]) == 3
    assert effective_count([1e-4, 1e-4 - 1e-9]) == pytest.approx(2, rel=1e-5)
    assert effective_count([2e-4, 1e-4]) == pytest.approx(1.5)
    assert effective_count([1e-4, 1e-9]) == pytest.approx(1, rel=1e-4), "continuous as a point comes and goes"


def test_contacts_of_balls_are_unchanged():
    """Their direction is exact; the correction of other shapes would cost several steps."""
    layer = ElasticLayer()
    ball = thing("sphere", at=(0.3, 0.01, 0.0398))
    model = assemble(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,), layer=layer)
    data = mujoco.MjData(model)
    mujoco.mj_step1(model, data)
    turned = np.array([0.0, np.sin(0.02), -np.cos(0.02)])
    data.contact.frame[0] = frame_along(turned).ravel()
    ContactSharing(model, layer).apply(data)
    assert data.contact.frame[0, :3] == pytest.approx(turned)


def test_roller_deep_in_the_cover_rolls_on_the_middle_of_its_depth():
    """The contact is half the depth d above the lowest point: a = g sin(slope) / (1 + (r / (r - d / 2))^2 / 2)."""
    made = bench("flat")
    effects = Effects(contact="environment", gravity="on", fingers=False, friction=True)
    layer = ElasticLayer(stiffness=STIFFNESS)
    model = assemble(made.robot, made.points, effects, objects=(lay("roller", (0.0, 0.0, 0.0), mass=5.0),), layer=layer)
    data = mujoco.MjData(model)
    sharing = ContactSharing(model, layer)
    friction = PassiveFriction(model)
    speeds = []
    for step in range(350):
        if step == 200:
            model.opt.gravity[:] = 9.81 * np.array([np.sin(0.1), 0.0, -np.cos(0.1)])
        mujoco.mj_step1(model, data)
        sharing.apply(data)
        friction.finish_step(data)
        speeds.append(float(data.qvel[0]))
    depth = -float(data.contact.dist.min())
    assert depth > 2e-3
    radius = BODIES["roller"].size[0]
    expected = 9.81 * np.sin(0.1) / (1 + 0.5 * (radius / (radius - depth / 2)) ** 2)
    found = (speeds[-1] - speeds[-101]) / (100 * model.opt.timestep)
    assert found == pytest.approx(expected, rel=0.005)
    assert found < 0.95 * 9.81 * np.sin(0.1) / 1.5

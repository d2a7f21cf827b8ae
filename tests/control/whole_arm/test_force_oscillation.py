"""Oscillation of the force: loops that would oscillate become calm, and taps of a person are no oscillation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Sampling
from tests.support.pressed_arm import TICK, forearm

pytestmark = pytest.mark.long

BENT = (0.27418, -0.89498, 0.09108, 0.0771, -1.43873, 1.41016, 0.24988)
"""Posture of our arm at which its upper arm hardly moves along the skin."""


def read_slowly(session: Session) -> Session:
    """Return the session with a skin that is read at 50 Hz, 20 ms late."""
    sensor = replace(session.effects.sensor, sampling=Sampling(50.0, 0.02))
    return Session(
        session.prepared,
        scripted=False,
        settings=session.settings,
        effects=replace(session.effects, sensor=sensor),
    )


@pytest.mark.long
@pytest.mark.parametrize("controller", ["projection", "hybrid", "hold_force"])
def test_force_on_a_cover_that_responds_to_acceleration_becomes_calm(controller):
    """The cover measures 1 kN/m but responds to acceleration like a much stiffer one: 0 to 8 N at 10 Hz."""
    scene = scene_for("arm")
    prepared = prepare_cached(
        replace(scene, cover=replace(scene.cover, links=(), taxels=1000, thickness=0.003), stimuli=(), motion=())
    )
    prepared = replace(prepared, robot=replace(prepared.robot, home=np.array(BENT)))
    layer = replace(prepared.scene.layer, stiffness=1e3)
    scene = with_fixed_ball(prepared, taxel=523, radius=0.03, model="water-fill", layer=layer, depth=1e-3)
    session = read_slowly(Session(scene, settings=ControlSettings(controller=controller)))
    forces = []
    found = set()
    for _ in range(round(6.0 / TICK)):
        found |= {limit.kind for limit in session.tick().why_limited}
        forces.append(session.total_normal_force)
    assert LimitKind.OSCILLATION in found, "it would oscillate"
    assert np.array(forces[-200:]) == pytest.approx(3.0, abs=0.15)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("controller", "period", "taps"),
    [
        pytest.param("hold_force", 0.25, 8),
        *(
            pytest.param(controller, period, 5, marks=pytest.mark.sampled(2))
            for controller in ("hybrid", "parallel", "hold_force")
            for period in (0.3, 0.4)
        ),
    ],
)
def test_taps_do_not_count_as_oscillation(controller, period, taps):
    prepared = forearm()
    session = Session(prepared, scripted=False, settings=ControlSettings(controller=controller))
    most = 0.0
    for k in range(round((taps * period + 1.0) / TICK)):
        for tap in range(taps):
            begins = 0.2 + tap * period
            if k == round(begins / TICK):
                finger = Finger(stiffness=3e3, speed=0.15, max_force=12.0)
                session.submit(PokePressed(1, prepared.skin.taxel_point(150), finger))
            if k == round((begins + 0.5 * period) / TICK):
                session.submit(PokeReleased(1))
        frame = session.tick()
        most = max(most, *(poke.force for poke in frame.pokes), 0.0)
        assert LimitKind.OSCILLATION not in {limit.kind for limit in frame.why_limited}
    assert most > 10.0, "they are felt"

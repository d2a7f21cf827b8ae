"""An hour of simulated time: a bar rocks a weight on its skin for 900,000 steps without drift or growth of memory.

The test takes some seconds, because the robot has one joint and ticks are long.
"""

from __future__ import annotations

import gc
import sys

import numpy as np
import pytest

from tactile_maps.scene.motion import Waypoint
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.hard_cases.touch import dressed, weight
from tests.support.touch import bar, bar_skin

HOUR = 3600.0
TICK = 0.4
STEP = 0.004
PERIOD = 4.0
"""Period of the rocking motion [s], a whole number of ticks."""
MASS = 0.5
_ROUND = round(PERIOD / TICK)
_MINUTE = round(60 / TICK)
_GROWN = 1000
"""Blocks of memory that an hour may leave behind: far less than one a tick."""
NOISY = {
    "gain_spread": "on",
    "noise": "on",
    "offset_drift": {"sd": 100.0, "walk": 0.5},
    "hysteresis": "on",
    "dead_taxels": "on",
    "sampling": {"rate": 2.0, "delay": 0.3},
}


def scene(**sensor) -> PreparedScene:
    """The bar rocks by 0.05 rad with a weight on its middle; without ``sensor`` the skin reads what it feels."""
    return dressed(
        bar(),
        bar_skin(),
        objects=(weight(MASS),),
        layer=ElasticLayer(friction=0.0),
        tick=TICK,
        seed=7,
        motion=(Waypoint((0.05,), seconds=PERIOD / 2), Waypoint((0.0,), seconds=PERIOD / 2)),
        overrides={"contact": "environment", "integrator": "implicitfast", "timestep": STEP, **sensor},
    )


def fingerprint(session: Session) -> list[bytes]:
    """The next minute, to the last bit."""
    frames = [session.tick() for _ in range(_MINUTE)]
    return [f.posture.tobytes() + f.velocity.tobytes() + f.pressures.tobytes() + f.objects.tobytes() for f in frames]


@pytest.fixture(scope="module")
def hour() -> dict[str, np.ndarray]:
    """An hour of the ideal skin: time, force, posture and height of every tick, and what the memory held."""
    session = Session(scene())
    areas = session.prepared.skin.areas
    ticks = round(HOUR / TICK)
    rows = np.zeros((ticks, 5))
    held = []
    for tick in range(ticks):
        frame = session.tick()
        clock = session._simulation.time
        rows[tick] = frame.time, clock, frame.pressures @ areas, frame.posture[0], frame.objects[0, 2, 3]
        if tick in (ticks // 6, ticks - 1):
            gc.collect()
            held.append(sys.getallocatedblocks())
    assert len(session.inputs) == 1, "no further input"
    return {"rows": rows, "held": np.array(held)}


@pytest.mark.long
def test_every_clock_advances_by_an_hour(hour):
    time, clock = hour["rows"][:, :2].T
    assert len(time) == HOUR / TICK
    assert time[-1] == pytest.approx(HOUR, abs=1e-9)
    assert np.abs(clock - time).max() < 1e-6


@pytest.mark.long
def test_motion_repeats_after_an_hour(hour):
    """After the first the motion repeats; force, posture and height of a phase are the same an hour later."""
    felt = hour["rows"][:, 2:]
    early = felt[2 * _ROUND : 3 * _ROUND]
    late = felt[-_ROUND:]
    assert np.ptp(early[:, 1]) > 0.02, "it rocks"
    assert late == pytest.approx(early, rel=1e-5, abs=1e-7)


@pytest.mark.long
def test_mean_force_stays_the_weight(hour):
    """Newton's second law: the skin's force leans with the bar; upwards it is m g but for what the rocking adds."""
    _, _, force, posture, _ = hour["rows"][_ROUND:].T
    rounds = (force * np.cos(posture)).reshape(-1, _ROUND).mean(axis=1)
    assert rounds == pytest.approx(MASS * 9.81, rel=0.02)
    assert np.ptp(rounds[1:]) < 1e-4 * MASS * 9.81


@pytest.mark.long
def test_memory_does_not_grow(hour):
    early, late = hour["held"]
    assert late - early < _GROWN


@pytest.mark.long
def test_noise_repeats_after_a_reset_and_in_another_session():
    """All that is random in a sensor starts again with a reset, and in another session, and is bounded meanwhile."""
    session = Session(scene(**NOISY))
    first = fingerprint(session)
    for _ in range(round(HOUR / 4 / TICK)):
        frame = session.tick()
    assert np.isfinite(frame.pressures).all()
    assert np.abs(frame.pressures).max() < 1e6
    later = fingerprint(session)
    assert len(set(first + later)) == len(first + later), "noise never repeats by itself"
    session.reset()
    assert fingerprint(session) == first
    assert fingerprint(Session(scene(**NOISY))) == first

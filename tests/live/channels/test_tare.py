"""Tare: baseline and noise of the untouched skin, and touches meanwhile."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.channels.tare import Tare, TouchedTares
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.maps.formats.map_file import save_map
from tactile_widgets.__main__ import main
from tests.support.touch import bar_map, bar_skin, prepared_bar

SKIN = bar_skin()
_AWAY = np.linalg.norm(SKIN.patches[0].taxels.positions - SKIN.patches[0].taxels.positions[30], axis=1)
PRESSED = np.round(400 * np.exp(-((_AWAY / 0.03) ** 2)))
"""Change of the values (60,) under a touch of about five taxels."""
CORE = set(np.flatnonzero(PRESSED > 100).tolist())
FIRM = set(np.flatnonzero(PRESSED > 150).tolist())
OFFSETS = np.random.default_rng(5).normal(2000, 4, 60).round()


def readings(pressed, seed=0):
    """Counts (readings, 60) with noise of a skin under pressures (readings, 60)."""
    return OFFSETS + np.random.default_rng(seed).normal(0, 1.5, (len(pressed), 60)).round() + pressed


def during(start, end, readings=50, shape=PRESSED):
    """Pressures (readings, 60) of a touch from one reading to another."""
    pressed = np.zeros((readings, 60))
    pressed[start:end] = shape
    return pressed


def tared(values, session=None):
    """Session that was tared with the values (readings, 60)."""
    session = session or MeasuredSession(as_measured(prepared_bar()), finite=True)
    session.tare(len(values))
    return shown(session, values)


def shown(session, values):
    """Session that has shown the values (readings, 60)."""
    for row in values:
        time = session.frame.time + 0.01
        session.show(Arrived(Reading(time, row, Unit.COUNTS), time))
    return session


def numbers(names):
    return {int(name.removeprefix("taxel ")) for name in names}


def test_tare_computes_mean_and_spread():
    random = np.random.default_rng(1)
    readings = 1e6 + random.normal(0, 2, (50, 3))
    tare = Tare(3, 50)
    assert [tare.add(row, np.arange(3)) for row in readings] == [False] * 49 + [True]
    mean, spread, counts = tare.result(np.zeros(tare.blocks.counts.shape, dtype=bool))
    assert counts.tolist() == [50, 50, 50]
    assert np.allclose(mean, readings.mean(0), rtol=0, atol=1e-8)
    assert np.allclose(spread, readings.std(0))
    with pytest.raises(LiveError, match="1 to 100,000"):
        Tare(3, 0)


def test_tare_counts_only_sent_values():
    """Values of other taxels are held in between and say nothing of the noise."""
    tare = Tare(3, 4)
    values = np.array([10.0, 20.0, 30.0])
    for taxel, value in ((0, 12.0), (1, 22.0), (0, 16.0), (1, 24.0)):
        values[taxel] = value
        tare.add(values, np.array([taxel]))
    mean, spread, counts = tare.result(np.zeros(tare.blocks.counts.shape, dtype=bool))
    assert mean.tolist() == [14.0, 23.0, 30.0]
    assert spread.tolist() == [2.0, 1.0, 0.0]
    assert counts.tolist() == [2, 2, 0]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "touch",
    [
        during(0, 30),
        during(15, 50),
        during(20, 30),
        during(48, 50),
        during(0, 2, readings=5),
        during(10, 18) + during(30, 36),
        during(5, 45, readings=60, shape=0.1 * PRESSED) + during(15, 35, readings=60),
    ],
    ids=["ends", "begins", "begins and ends", "last readings", "of five", "twice", "grows and shrinks"],
)
def test_touch_during_part_of_the_tare_is_excluded_and_reported(touch):
    session = tared(readings(touch))
    assert numbers(session.facts.touched_in_tare) >= CORE
    assert session.facts.held_in_tare == ()
    shown(session, readings(during(0, 0, readings=1), seed=1))
    assert session.frame.regions == ()
    shown(session, readings(during(0, 1, readings=1), seed=1))
    (contact,) = session.frame.regions
    assert contact.peak == pytest.approx(400e3, rel=0.02)


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(1, 5))])
@pytest.mark.parametrize("frames", [5, 20, 50])
def test_noise_and_drift_during_the_tare_are_not_a_touch(seed, frames):
    drift = np.linspace(0, 30, frames)[:, None] * np.ones(60)
    session = tared(readings(drift, seed))
    assert session.facts.touched_in_tare == session.facts.held_in_tare == ()


@pytest.mark.parametrize("seed", [10009, pytest.param(10001, marks=pytest.mark.long)])
def test_clipped_noise_during_the_tare_is_not_a_touch(seed):
    """A few readings of neighbours may be 0 together, which shows no noise."""
    skin = bar_skin(400, finer=3)
    tare = Tare(len(skin), 10)
    for row in np.maximum(20 * np.random.default_rng(seed).standard_normal((10, len(skin))), 0):
        tare.add(row, np.arange(len(skin)))
    assert not TouchedTares(skin).touched(tare, np.full(len(skin), 1e3)).any()


def test_touch_during_the_whole_tare_is_reported_with_its_taxels():
    session = tared(readings(during(0, 50)))
    assert numbers(session.facts.held_in_tare) >= FIRM
    assert session.facts.touched_in_tare == ()
    shown(session, readings(during(0, 0, readings=10), seed=1))
    assert session.facts.falling
    assert numbers(session.facts.falling_taxels) >= CORE


def test_weaker_touch_is_reported_in_a_second_tare_by_comparison_with_the_first():
    weaker = 0.15 * PRESSED
    assert tared(readings(during(0, 50, shape=weaker))).facts.held_in_tare == ()
    session = tared(readings(during(0, 0)))
    tared(readings(during(0, 50, shape=weaker), seed=1), session)
    assert set(np.flatnonzero(weaker > 12).tolist()) <= numbers(session.facts.held_in_tare)
    tared(readings(during(0, 0), seed=2), session)
    assert session.facts.held_in_tare == ()


def test_touch_is_detected_in_values_that_decrease_under_pressure():
    session = MeasuredSession(as_measured(prepared_bar()), finite=True, inverted=True)
    tared(2 * OFFSETS - readings(during(20, 50)), session)
    assert numbers(session.facts.touched_in_tare) >= CORE


def test_listen_names_the_taxels_that_were_touched_during_the_tare(tmp_path, capsys):
    skin = tmp_path / "skin.npz"
    save_map(bar_map(), skin)
    for touch, key, text in (
        (during(10, 60, readings=80), "touched_in_tare", "the readings meanwhile were left out for"),
        (during(0, 80, readings=80), "held_in_tare", "read far more than the others during the tare"),
    ):
        path = tmp_path / f"{key}.csv"
        lines = [",".join(map(str, [0.01 * n, *row])) for n, row in enumerate(readings(touch))]
        path.write_text("\n".join(["time," + ",".join(map(str, range(60))), *lines, ""]))
        assert main(["listen", str(path), "--skin", str(skin), "--tare", "50", "--json"]) == 0
        captured = capsys.readouterr()
        assert text in captured.err
        assert len(json.loads(captured.out)[key]) >= len(FIRM)

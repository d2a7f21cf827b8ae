"""Strokes over skins with gaps between electrodes, read fast and slowly: each is one contact; taps are several."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.contacts.lost import GAP
from app.geometry.closest import ClosestPoint
from app.geometry.surface_point import SurfacePoint
from app.maps.build import build_map
from app.session.prepare import Prepared
from app.session.session import Session
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.touch.sensor.area_averaging import AreaAveraging
from app.touch.sensor.sampling import Sampling
from tests.touch import bar_skin, prepared_bar

TIP = Finger(radius=0.006, max_force=5.0, speed=1.0)
"""Of the finger: narrower than the gaps."""


@cache
def gappy() -> Prepared:
    """The bar, fixed, in taxels 11 mm apart."""
    skin = bar_skin(300)
    bare = prepared_bar(hinged=False)
    return Prepared(bare.scene, bare.robot, skin, build_map(skin))


def session_at(rate: float) -> Session:
    """Electrodes of 1.9 mm radius, read ``rate`` times a second."""
    prepared = gappy()
    effects = prepared.scene.effects
    sensor = replace(effects.sensor, area_averaging=AreaAveraging(), sampling=Sampling(rate, 0.0))
    return Session(prepared, effects=replace(effects, fingers=True, sensor=sensor), scripted=False)


def place(x: float, y: float) -> SurfacePoint:
    """On the bar's top."""
    faces, weights, _ = ClosestPoint(gappy().skin.patches[0].surface).query(np.array([[x, y, 0.02]]))
    a, b, c = weights[0].tolist()
    return SurfacePoint(0, int(faces[0]), (a, b, c))


def kinds(events, *wanted: str) -> list[str]:
    return [event.kind for event in events if event.kind in wanted]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rate", [5.0, 20.0, 100.0])
def test_a_stroke_over_gaps_is_one_contact(rate, seed):
    random, session, speed, events = np.random.default_rng(seed), session_at(rate), 0.08, []
    away = gappy().skin.patches[0].taxels.positions
    start = away[np.argmin(np.hypot(away[:, 0] - 0.06, away[:, 1] - random.uniform(-0.03, 0.03)))]
    tick, lost, ids = gappy().scene.tick, 0, set()
    session.submit(PokePressed(1, place(*start[:2]), TIP))
    for number in range(60 + round(0.25 / speed / tick)):
        if number > 60:
            session.submit(PokeMoved(1, place(start[0] + speed * tick * (number - 60), start[1])))
        frame = session.tick()
        events += frame.events
        lost += number > 60 and not frame.regions
        ids |= {region.id for region in frame.regions}
    assert lost * tick > 0.1, "it falls between taxels"
    assert kinds(events, "touch", "release") == ["touch"]
    assert len(ids) == 1
    session.submit(PokeReleased(1))
    for _ in range(round((GAP + 2.5 / rate) / tick)):
        events += session.tick().events
    assert kinds(events, "touch", "release", "stroke") == ["touch", "stroke", "stroke", "release"]
    way = next(event.travelled for event in events if event.kind == "stroke" and event.phase == "ended")
    assert 0.15 < way < 0.4, "from taxel to taxel, aside as well"


@pytest.mark.parametrize("rate", [20.0, 100.0])
def test_taps_in_one_place_are_as_many_as_they_are(rate):
    session, events = session_at(rate), []
    at = gappy().skin.taxel_point(130)
    for _ in range(4):
        session.submit(PokePressed(1, at, TIP))
        for _ in range(30):
            events += session.tick().events
        session.submit(PokeReleased(1))
        for _ in range(30):
            events += session.tick().events
    for _ in range(100):
        events += session.tick().events
    assert kinds(events, "tap") == ["tap"] * 4
    assert kinds(events, "touch", "release") == ["touch", "release"] * 4

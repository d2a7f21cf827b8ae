"""Recorded pokes become a script that repeats them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import Session
from tactile_maps.stimuli.skin_locations import SkinLocator
from tactile_maps.stimuli.stimuli_from_pokes import TOLERANCE, stimuli_from_pokes
from tactile_maps.stimuli.stimulus_file import stimuli_from_toml, stimuli_to_toml
from tactile_maps.stimuli.stimulus_player import FIRST_SCRIPTED_FINGER, StimulusPlayer
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tests.support.touch import arm, bar_skin

TICK = 0.005
SKIN = bar_skin()
TIP = Finger(max_force=3.0, speed=0.02)


def at(x: float, y: float = 0.0):
    return SkinLocator(SKIN).surface_point(0, np.array([x, y, 0.02]))


def wander(seed: int, *, patch: int = 1, id: int = 1) -> list:
    """A hand as a mouse moves it: a place every 12 to 20 ms, at a changing speed, with a rest on the way."""
    locator = SkinLocator(arm().skin)
    generator = np.random.default_rng(seed)
    times = np.cumsum(generator.integers(3, 5, 150))
    times[80:] += 100
    angles = np.cumsum(generator.normal(scale=0.15, size=150))
    steps = 0.002 * generator.uniform(0.2, 1.0, 150)[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    plane = np.cumsum(steps, axis=0)
    start = locator.point(patch, (0.3, 0.2))
    points = locator.project(patch, start + np.stack([plane[:, 0], 0 * plane[:, 0], plane[:, 1]], 1))
    acts = [(40, PokePressed(id, locator.surface_point(patch, points[0]), TIP))]
    acts += [(40 + int(t), PokeMoved(id, locator.surface_point(patch, p))) for t, p in zip(times, points, strict=True)]
    return [*acts, (acts[-1][0] + 60, PokeReleased(id))]


def kinds(stimuli) -> list[str]:
    return [stimulus.kind for stimulus in stimuli]


def test_press_without_motion_is_a_poke():
    acts = [(10, PokePressed(1, at(0.1), TIP)), (90, PokeMoved(1, at(0.1003))), (110, PokeReleased(1))]
    (poke,) = stimuli_from_pokes(SKIN, acts, tick=TICK)
    assert poke.kind == "poke"
    assert (poke.patch, poke.at, poke.hold, poke.begin, poke.tip) == ("top", (0.1, 0.0, 0.02), 0.5, 0.0, TIP)


def test_straight_motion_at_constant_speed_becomes_a_stroke():
    moves = [(60 + k, PokeMoved(1, at(0.1 + 0.0005 * k))) for k in range(201)]
    acts = [(10, PokePressed(1, at(0.1), TIP)), *moves, (300, PokeReleased(1))]
    (stroke,) = stimuli_from_pokes(SKIN, acts, tick=TICK)
    assert stroke.kind == "stroke"
    assert (stroke.start, stroke.end) == ((0.1, 0.0, 0.02), (0.2, 0.0, 0.02))
    assert stroke.speed == pytest.approx(0.1, rel=0.02)
    assert stroke.hold == pytest.approx(0.25, abs=2 * TICK)
    assert stroke.hold + 0.1 / stroke.speed + stroke.stay == pytest.approx(290 * TICK, abs=TICK)


def test_moving_finger_becomes_a_path_through_all_its_positions():
    acts = wander(1)
    (path,) = stimuli_from_pokes(arm().skin, acts, tick=TICK)
    assert path.kind == "path"
    assert 5 < len(path.points) < 75, "as few points as it needs"
    again = StimulusPlayer(arm().skin, stimuli_from_toml(stimuli_to_toml([path]), file="x"), tick=TICK)
    where = places(arm().skin, [(tick, act) for tick in range(again.ticks) for act in again.inputs(tick)])
    reported = places(arm().skin, acts)
    assert len(reported) == 152
    for tick, point in reported.items():
        now = max(known for known in where if known <= tick - 40)
        assert np.linalg.norm(where[now] - point) < 2 * TOLERANCE, "within 1 mm"


def places(skin, acts) -> dict[int, np.ndarray]:
    last = {tick: act.at for tick, act in acts if not isinstance(act, PokeReleased)}
    last |= {tick: list(last.values())[-1] for tick, act in acts if isinstance(act, PokeReleased) and tick not in last}
    return {tick: skin.position(place) for tick, place in last.items()}


@pytest.mark.long
def test_played_back_stimulus_gives_the_same_readings():
    """The forces on the skin, tick by tick, through TOML and back, with the arm yielding."""
    prepared = arm()
    acts = [*wander(2), *wander(3, patch=2, id=2)]

    def felt(script, hand):
        session = Session(replace(prepared, scene=replace(prepared.scene, stimuli=script)), scripted=not hand)
        forces = []
        for tick in range(acts[-1][0] - 40):
            for when, act in acts:
                if hand and when == tick + 40:
                    session.submit(act)
            forces.append(session.tick().pressures @ prepared.skin.areas)
        return np.array(forces)

    script = stimuli_from_toml(stimuli_to_toml(stimuli_from_pokes(prepared.skin, acts, tick=TICK)), file="x")
    assert kinds(script) == ["path", "path"]
    before = felt((), True)
    after = felt(script, False)
    assert before.max() > 4.0
    assert (before > 1.0).mean() > 0.8
    assert np.abs(after - before).max() < 0.02 * before.max()
    assert np.abs(after - before).mean() < 0.005 * before.max()


def test_pause_during_a_motion_is_kept():
    moves = [(10 + k, PokeMoved(1, at(0.1 + 0.002 * k))) for k in range(20)]
    moves += [(300 + k, PokeMoved(1, at(0.15 + 0.002 * k))) for k in range(20)]
    (path,) = stimuli_from_pokes(SKIN, [(0, PokePressed(1, at(0.1), TIP)), *moves, (400, PokeReleased(1))], tick=TICK)
    (track,) = path.tracks(SkinLocator(SKIN))
    for tick in (40, 160, 290):
        assert track.at(tick * TICK)[1][0] == pytest.approx(0.138, abs=TOLERANCE)


def test_touches_keep_their_times_and_may_overlap():
    acts = [
        (100, PokePressed(1, at(0.1), TIP)),
        (120, PokePressed(2, at(0.3), TIP)),
        (200, PokeReleased(1)),
        (220, PokeReleased(2)),
        (300, PokePressed(1, at(0.2), TIP)),
        (340, PokeReleased(1)),
    ]
    script = stimuli_from_pokes(SKIN, acts, tick=TICK)
    assert [(poke.begin, poke.hold, poke.at[0]) for poke in script] == [
        (0.0, 0.5, 0.1),
        (0.1, 0.5, 0.3),
        (1.0, 0.2, 0.2),
    ]


def test_unusual_sequences_of_pokes_become_valid_stimuli():
    """Pressed twice, moved and lifted without a press, never lifted, lifted in the tick of the press."""
    acts = [
        (0, PokeMoved(1, at(0.1))),
        (1, PokeReleased(1)),
        (5, PokePressed(1, at(0.1), TIP)),
        (25, PokePressed(1, at(0.2), TIP)),
        (30, PokePressed(2, at(0.3), TIP)),
        (30, PokeReleased(2)),
    ]
    script = stimuli_from_pokes(SKIN, acts, tick=TICK, last=105)
    assert [(poke.at[0], poke.hold) for poke in script] == [(0.1, 0.1), (0.2, 0.4), (0.3, TICK)]
    assert stimuli_from_pokes(SKIN, acts, tick=TICK)[1].hold == pytest.approx(6 * TICK)
    assert stimuli_from_pokes(SKIN, acts[:2], tick=TICK) == ()


def test_scripted_pokes_are_included_on_request_only():
    acts = [
        (0, ControlChanged(ControlSettings())),
        (1, PokePressed(FIRST_SCRIPTED_FINGER, at(0.1), TIP)),
        (9, PokeReleased(FIRST_SCRIPTED_FINGER)),
        (20, PokePressed(1, at(0.2), TIP)),
        (40, PokeReleased(1)),
    ]
    assert [poke.at[0] for poke in stimuli_from_pokes(SKIN, acts, tick=TICK)] == [0.2]
    assert [poke.at[0] for poke in stimuli_from_pokes(SKIN, acts, tick=TICK, scripted=True)] == [0.1, 0.2]


def test_steps_to_another_patch_need_no_more_points():
    """The places before the step are in another frame than those after it: no straight way leads there."""
    skin = arm().skin
    locator = SkinLocator(arm().skin)
    start = locator.point(1, (0.3, 0.2))
    way = locator.straight_path(1, start, start + [0.0, 0.0, 0.02])
    acts = [(5 * k, PokeMoved(1, locator.surface_point(1, point))) for k, point in enumerate(way)]
    acts[0] = (0, PokePressed(1, locator.surface_point(1, way[0]), TIP))
    hand = locator.surface_point(2, locator.point(2, (0.5, 0.2)))
    (path,) = stimuli_from_pokes(skin, [*acts, (120, PokeMoved(1, hand)), (150, PokeReleased(1))], tick=TICK)
    assert len(path.points) == 4, "press, last place before the step, step, lift"
    assert path.patches[-2:] == ("hand", "hand")

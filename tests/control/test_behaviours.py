"""Behaviours, and the events that trigger them."""

from __future__ import annotations

import pytest

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.control.behaviours import WITHIN, Behaviour, BehaviourTrigger, behaviours_from, trigger_text
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SceneError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tests.support.touch import bar_skin

RETREAT = {"task": "retreat"}


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"on": "tap"}, "tap"),
        ({"on": "tap", "times": 2, "where": "upper_arm"}, "double tap on upper arm"),
        ({"on": "press", "above": 5.0}, "press above 5\u202fN"),
        ({"on": "touch", "times": 4}, "4 times touch"),
    ],
)
def test_it_is_called_by_what_triggers_it(said, words):
    assert Behaviour(then=RETREAT, **said).words == words


@pytest.mark.parametrize(
    ("said", "place", "words"),
    [
        ({"on": "tab"}, "behaviours.on", "Did you mean tap?"),
        ({"on": "tap", "times": 0}, "behaviours.times", "1 to 5"),
        ({"on": "tap", "times": 6}, "behaviours.times", "1 to 5"),
        ({"on": "tap", "above": -1.0}, "behaviours.above", "0 to 200"),
        ({"on": "tap", "above": float("nan")}, "behaviours.above", "0 to 200"),
        ({"on": "tap", "until_released": True}, "behaviours.until_released", "press"),
        ({"on": "tap", "times": True}, "behaviours.times", "1 to 5"),
        ({"on": "tap", "above": "much"}, "behaviours.above", "0 to 200"),
        ({"on": "tap", "where": 3}, "behaviours.where", "quotes"),
        ({"on": "tap", "until_released": "yes"}, "behaviours.until_released", "true or false"),
        ({"on": "tap", "then": {}}, "behaviours.then", "retreat"),
        ({"on": "tap", "then": "retreat"}, "behaviours.then", "retreat"),
        ({"on": "tap", "then": {"task": "dance"}}, "behaviours.then.task", "keep_force"),
        ({"on": "tap", "then": {"force": 1.0}}, "behaviours.then.force", "Did you mean"),
        ({"on": "tap", "then": {"force_goal": -1.0}}, "behaviours.then.force_goal", "0 to 20"),
    ],
)
def test_what_makes_no_sense_is_refused(said, place, words):
    with pytest.raises(SceneError, match=words) as caught:
        Behaviour(**{"then": RETREAT, **said})
    assert caught.value.place == place


def test_tables_of_a_scene_become_behaviours():
    tables = [{"on": "tap", "then": RETREAT}, {"on": "press", "above": 2, "until_released": True, "then": RETREAT}]
    assert behaviours_from(tables) == (
        Behaviour("tap", then=RETREAT),
        Behaviour("press", above=2, until_released=True, then=RETREAT),
    )


@pytest.mark.parametrize(
    ("table", "place"),
    [
        ({"then": RETREAT}, "behaviours.1"),
        ({"on": "tap", "than": RETREAT}, "behaviours.1.than"),
        ({"on": "tap", "then": {"task": "dance"}}, "behaviours.1.then.task"),
    ],
)
def test_a_mistake_in_a_table_is_placed(table, place):
    with pytest.raises(SceneError) as caught:
        behaviours_from([{"on": "tap", "then": RETREAT}, table])
    assert caught.value.place == place


PLAIN = ControlSettings(controller="hybrid")


def event(kind="tap", *, time=1.0, force=2.0, link="bar") -> ContactEvent:
    phase = "ended" if kind in ("tap", "release") else "began"
    at = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    return ContactEvent(round(time * 200), time, kind, phase, (1,), (link,), at, force=force)


def watch(*behaviours: Behaviour) -> BehaviourTrigger:
    return BehaviourTrigger(bar_skin(), behaviours)


def test_only_the_event_that_is_named_triggers():
    waiting = watch(Behaviour("tap", then=RETREAT))
    assert waiting.triggered([event("press"), event("touch")], PLAIN, touched=True) is None
    settings, why = waiting.triggered([event("tap")], PLAIN, touched=False)
    assert settings == ControlSettings(controller="hybrid", task="retreat")
    assert (why, trigger_text(why)) == (waiting.behaviours[0], "tap")


def test_what_changes_nothing_triggers_nothing():
    assert watch(Behaviour("tap", then={"controller": "hybrid"})).triggered([event()], PLAIN, touched=False) is None


def test_the_end_of_a_press_is_not_its_beginning():
    ended = ContactEvent(9, 1.0, "press", "ended", (1,), ("bar",), SurfacePoint(0, 0, (1.0, 0.0, 0.0)), force=9.0)
    assert watch(Behaviour("press", then=RETREAT)).triggered([ended], PLAIN, touched=False) is None


@pytest.mark.parametrize(("force", "expected"), [(4.9, False), (5.1, True)])
def test_weaker_events_do_not_count(force, expected):
    waiting = watch(Behaviour("press", above=5.0, then=RETREAT))
    assert (waiting.triggered([event("press", force=force)], PLAIN, touched=True) is not None) == expected


@pytest.mark.parametrize(("pause", "expected"), [(0.9 * WITHIN, True), (1.1 * WITHIN, False)])
def test_two_taps_in_a_row_are_a_double_tap(pause, expected):
    waiting = watch(Behaviour("tap", times=2, then=RETREAT))
    assert waiting.triggered([event(time=1.0)], PLAIN, touched=False) is None
    assert (waiting.triggered([event(time=1.0 + pause)], PLAIN, touched=False) is not None) == expected
    if expected:
        assert waiting.triggered([event(time=1.1 + pause)], PLAIN, touched=False) is None, "counting starts again"


def test_settings_come_back_when_nothing_touches():
    waiting = watch(Behaviour("press", until_released=True, then=RETREAT))
    settings, _ = waiting.triggered([event("press")], PLAIN, touched=True)
    assert waiting.triggered([], settings, touched=True) is None
    assert waiting.triggered([event("release")], settings, touched=False) == (PLAIN, "released")
    assert waiting.triggered([], PLAIN, touched=False) is None


def test_nothing_comes_back_over_what_a_person_chose():
    waiting = watch(Behaviour("press", until_released=True, then=RETREAT))
    waiting.triggered([event("press")], PLAIN, touched=True)
    waiting.settled()
    assert waiting.triggered([], ControlSettings(controller="qp"), touched=False) is None


def test_the_last_behaviour_has_the_last_word():
    waiting = watch(Behaviour("tap", then=RETREAT), Behaviour("tap", then={"task": "guide", "force_goal": 1.0}))
    settings, _ = waiting.triggered([event()], PLAIN, touched=False)
    assert (settings.task, settings.force_goal) == ("guide", 1.0)


def test_place_is_link_or_patch():
    skin = bar_skin()
    [patch] = skin.patches
    for place in {patch.link, patch.name}:
        assert watch(Behaviour("tap", where=place, then=RETREAT)).triggered([event()], PLAIN, touched=False)


def test_a_place_there_is_not_is_refused():
    with pytest.raises(SceneError, match="top") as caught:
        watch(Behaviour("tap", then=RETREAT), Behaviour("tap", where="elbow", then=RETREAT))
    assert caught.value.place == "behaviours.1.where"


def test_a_reset_forgets():
    waiting = watch(Behaviour("tap", times=2, then=RETREAT), Behaviour("press", until_released=True, then=RETREAT))
    waiting.triggered([event("press")], PLAIN, touched=True)
    waiting.triggered([event()], PLAIN, touched=True)
    assert waiting.reset() == PLAIN, "what a release would have brought back"
    assert waiting.reset() is None
    assert waiting.triggered([event(time=1.1)], PLAIN, touched=False) is None

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
PLAIN = ControlSettings(controller="hybrid")


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"on": "tap"}, "tap"),
        ({"on": "tap", "times": 2, "where": "upper_arm"}, "double tap on upper arm"),
        ({"on": "press", "above": 5.0}, "press above 5\u202fN"),
        ({"on": "touch", "times": 4}, "4 times touch"),
    ],
)
def test_behaviour_is_described_by_its_event(fields, words):
    behaviour = Behaviour(then=RETREAT, **fields)
    assert behaviour.words == trigger_text(behaviour) == words


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("on", ["tab"], "Did you mean tap?"),
        ("times", [0, 6, True], "1 to 5"),
        ("above", [-1.0, float("nan"), "much"], "0 to 200"),
        ("until_released", [True], "press"),
        ("until_released", ["yes"], "true or false"),
        ("where", [3], "quotes"),
        ("then", [{}, "retreat"], "retreat"),
        ("then.task", ["dance"], "keep_force"),
        ("then.force", [1.0], "Did you mean"),
        ("then.force_goal", [-1.0], "0 to 20"),
    ],
)
def test_invalid_field_raises_with_its_place(name, values, message):
    for value in values:
        field, _, setting = name.partition(".")
        fields = {"on": "tap", "then": RETREAT, field: {setting: value} if setting else value}
        with pytest.raises(SceneError, match=message) as caught:
            Behaviour(**fields)
        assert caught.value.place == f"behaviours.{name}"


def test_tables_of_a_scene_become_behaviours():
    tables = [{"on": "tap", "then": RETREAT}, {"on": "press", "above": 2, "until_released": True, "then": RETREAT}]
    assert behaviours_from(tables) == tuple(Behaviour(**table) for table in tables)


@pytest.mark.parametrize(
    ("table", "place"),
    [
        ({"then": RETREAT}, "behaviours.1"),
        ({"on": "tap", "than": RETREAT}, "behaviours.1.than"),
        ({"on": "tap", "then": {"task": "dance"}}, "behaviours.1.then.task"),
    ],
)
def test_invalid_table_raises_with_its_number(table, place):
    with pytest.raises(SceneError) as caught:
        behaviours_from([{"on": "tap", "then": RETREAT}, table])
    assert caught.value.place == place


def event(kind="tap", *, time=1.0, force=2.0, phase=None) -> ContactEvent:
    phase = phase or ("ended" if kind in ("tap", "release") else "began")
    at = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    return ContactEvent(round(time * 200), time, kind, phase, (1,), ("bar",), at, force=force)


class Bench(BehaviourTrigger):
    """Behaviours on the bar; each has the settings of a retreat by default."""

    def __init__(self, on="tap", **fields) -> None:
        super().__init__(bar_skin(), [Behaviour(on, **{"then": RETREAT, **fields})])

    def happens(self, *events, settings=PLAIN, touched=False):
        return self.triggered(events, settings, touched=touched)


def test_only_the_named_event_triggers():
    bench = Bench()
    assert bench.happens(event("press"), event("touch"), touched=True) is None
    settings, why = bench.happens(event())
    assert settings == ControlSettings(controller="hybrid", task="retreat")
    assert why is bench.behaviours[0]
    assert Bench("press").happens(event("press", phase="ended")) is None, "the end of a press"
    assert Bench(then={"controller": "hybrid"}).happens(event()) is None, "it changes nothing"


@pytest.mark.parametrize(("force", "expected"), [(4.9, False), (5.1, True)])
def test_weaker_events_do_not_count(force, expected):
    assert (Bench("press", above=5.0).happens(event("press", force=force)) is not None) == expected


@pytest.mark.parametrize(("pause", "expected"), [(0.9 * WITHIN, True), (1.1 * WITHIN, False)])
def test_two_taps_in_a_row_are_a_double_tap(pause, expected):
    bench = Bench(times=2)
    assert bench.happens(event(time=1.0)) is None
    assert (bench.happens(event(time=1.0 + pause)) is not None) == expected
    if expected:
        assert bench.happens(event(time=1.1 + pause)) is None, "counting starts again"


def test_settings_return_when_nothing_touches_unless_the_user_chose_others():
    bench = Bench("press", until_released=True)
    settings, _ = bench.happens(event("press"), touched=True)
    assert bench.happens(settings=settings, touched=True) is None
    assert bench.happens(event("release"), settings=settings) == (PLAIN, "released")
    assert bench.happens() is None
    bench.happens(event("press"), touched=True)
    bench.settled()
    assert bench.happens(settings=ControlSettings(controller="qp")) is None


def test_last_behaviour_has_precedence():
    bench = Bench()
    bench.use([*bench.behaviours, Behaviour("tap", then={"task": "guide", "force_goal": 1.0})])
    settings, _ = bench.happens(event())
    assert (settings.task, settings.force_goal) == ("guide", 1.0)


def test_place_is_the_name_of_a_link_or_patch():
    [patch] = bar_skin().patches
    for place in {patch.link, patch.name}:
        assert Bench(where=place).happens(event())
    bench = Bench()
    with pytest.raises(SceneError, match="top") as caught:
        bench.use([*bench.behaviours, Behaviour("tap", where="elbow", then=RETREAT)])
    assert caught.value.place == "behaviours.1.where"
    assert len(bench.behaviours) == 1


def test_reset_discards_events_and_returns_the_settings_of_a_release():
    bench = Bench(times=2)
    bench.use([*bench.behaviours, Behaviour("press", until_released=True, then=RETREAT)])
    bench.happens(event("press"), touched=True)
    bench.happens(event(), touched=True)
    assert (bench.reset(), bench.reset()) == (PLAIN, None)
    assert bench.happens(event(time=1.1)) is None

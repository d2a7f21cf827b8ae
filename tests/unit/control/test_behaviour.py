"""Behaviours as values: what they are called, and what they refuse."""

from __future__ import annotations

import pytest

from app.control.behaviour import Behaviour, behaviours_from
from app.errors import SceneError

RETREAT = {"task": "retreat"}


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"on": "tap"}, "tap"),
        ({"on": "tap", "times": 2, "where": "upper_arm"}, "double tap on upper arm"),
        ({"on": "press", "above": 5.0}, "press above 5\u2009N"),
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

"""The side from which a scene is first looked at: the usual one, unless the robot hides there what it is about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.robots.configuration import Configuration
from app.scene.bodies import make_bodies
from app.scene.objects import ObjectSpec
from tests.touch import arm
from widgets.robot_view.first_side import AWAY, first_side


def side_with(*things: ObjectSpec) -> np.ndarray:
    prepared = arm()
    scene = replace(prepared.scene, objects=things, task="slide", outputs=("force",))
    made = replace(prepared, scene=scene, objects=make_bodies(scene))
    return first_side(made, Configuration(prepared.robot).poses())


def ball(name: str, *at: float) -> ObjectSpec:
    return ObjectSpec(name, "sphere", (0.03,), at=at)


def test_without_things_it_is_the_usual_one():
    assert side_with() == pytest.approx(AWAY)


def test_what_can_be_seen_from_there_changes_nothing():
    assert side_with(ball("free", 0.5, 0.4, 0.4)) == pytest.approx(AWAY)


def test_what_the_robot_hides_is_looked_at_from_where_it_shows():
    """A ball behind the forearm, where our arm at home stands between it and the usual eye."""
    hidden = ball("hidden", 0.2142, -0.0008, 0.5822)
    side = side_with(hidden)
    assert side != pytest.approx(AWAY)
    assert np.abs(side) == pytest.approx(np.abs(AWAY)), "one of the four quarters"


def test_most_things_decide():
    hidden = ball("hidden", 0.2142, -0.0008, 0.5822)
    free = [ball(f"free {k}", 0.5, 0.3 + 0.1 * k, 0.4) for k in range(9)]
    assert side_with(hidden, *free) == pytest.approx(AWAY)

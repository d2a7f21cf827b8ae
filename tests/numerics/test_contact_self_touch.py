"""The shipped scene of a hand that strokes a forearm: two regions, one contact, told as such from first to last."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from app.robots.configuration import Configuration
from app.scene.scene_file import load_scene
from app.session.frame import Frame
from app.session.prepare import Prepared, prepare
from app.session.session import Session


@cache
def run() -> tuple[Prepared, tuple[Frame, ...]]:
    prepared = prepare(load_scene("self_touch"))
    session = Session(prepared)
    return prepared, tuple(session.tick() for _ in range(round(7.5 / prepared.scene.tick)))


def test_both_sides_are_linked_as_long_as_both_are_felt():
    _, frames = run()
    both = [frame.regions for frame in frames if len({region.link for region in frame.regions}) == 2]
    assert len(both) > 500, "they touch for seconds"
    for one, other in both:
        assert (one.partner, other.partner) == (other.id, one.id)


def test_alone_no_region_has_a_partner():
    _, frames = run()
    alone = [frame.regions for frame in frames if len(frame.regions) == 1]
    assert alone
    assert all(region.partner == 0 for (region,) in alone)


def test_partners_feel_one_force_at_one_place():
    prepared, frames = run()
    configuration = Configuration(prepared.robot)
    for frame in frames[::20]:
        if len(frame.regions) == 2:
            configuration.update(frame.posture)
            one, other = frame.regions
            at = [configuration.pose(region.link).points(region.point) for region in frame.regions]
            assert one.force == pytest.approx(other.force, rel=1e-6)
            assert np.linalg.norm(at[0] - at[1]) < one.place_error + other.place_error


def test_it_is_told_in_words():
    _, frames = run()
    events = [event for frame in frames for event in frame.events]
    assert [event.kind for event in events].count("self-touch") == 2
    told = [event for event in events if event.phase == "ended"]
    words = [event.words for event in told]
    assert any(text.startswith("left hand touches right forearm, ") for text in words)
    stroke = next(event for event in told if event.kind == "stroke")
    assert stroke.links == ("right_forearm",), "along it goes the hand, which is pressed at one place"
    assert 0.04 < stroke.travelled < 0.12
    assert not any(event.kind == "grasp" for event in events)


def test_the_same_again_gives_the_same_events():
    prepared, frames = run()
    session = Session(prepared)
    for frame in frames[:1000]:
        assert session.tick().recent == frame.recent
    assert session.frame.recent
    session.reset()
    assert session.frame.recent == ()

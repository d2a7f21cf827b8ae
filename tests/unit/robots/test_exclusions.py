"""Neighbours that always touch are excluded; those that only may touch are not."""

from __future__ import annotations

import mujoco
import numpy as np

from app.robots.exclusions import pairs_to_exclude

CHAIN = """<mujoco><worldbody><body name="base"><geom size="0.1"/>
<body name="near" pos="0 0 0.1"><joint axis="0 1 0" limited="true" range="-90 90"/><geom size="0.1"/>
<body name="mid" pos="0 0 0.1"><joint axis="0 1 0" limited="true" range="-90 90"/><geom size="0.1"/>
<body name="far" pos="0 0 1"><joint type="slide" axis="0 0 1" limited="true" range="-1.2 5"/><geom size="0.1"/>
</body></body></body></body></worldbody></mujoco>"""


def test_lasting_overlaps_are_found_and_passing_ones_left() -> None:
    model = mujoco.MjModel.from_xml_string(CHAIN)
    assert pairs_to_exclude(model, np.zeros(3)) == [("base", "mid"), ("base", "near")]


def test_a_pair_that_touches_at_home_is_excluded() -> None:
    model = mujoco.MjModel.from_xml_string(CHAIN)
    assert ("near", "far") in pairs_to_exclude(model, np.array([0.0, 0.0, -1.1]))


def test_a_child_of_a_fixed_link_is_excluded_even_apart() -> None:
    model = mujoco.MjModel.from_xml_string(CHAIN.replace('name="near" pos="0 0 0.1"', 'name="near" pos="0 0 3"'))
    assert pairs_to_exclude(model, np.zeros(3)) == [("base", "near")]


def test_the_answer_does_not_depend_on_the_day() -> None:
    model = mujoco.MjModel.from_xml_string(CHAIN)
    assert pairs_to_exclude(model, np.zeros(3), seed=1) == pairs_to_exclude(model, np.zeros(3), seed=1)

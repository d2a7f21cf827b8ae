"""A robot beside a ball: where it is pressed, and what its controller believes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.contacts.reading_settings import ReadingSettings
from app.control.command import ControlSettings
from app.errors import SkinError
from app.experiments.control_setup import BALL, DEPTH, ControlSetup, beside_ball, over, place_to_press
from app.maps.build import build_map
from app.skin.misplace import misplaced
from app.skin.skin import Skin
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from tests.numerics.pressed_arm import forearm


def test_the_place_has_room_and_is_flat():
    prepared = forearm()
    taxel, taxels = place_to_press(prepared), prepared.skin.patches[0].taxels
    edges = np.concatenate([*prepared.map.outlines, *(seams.reshape(-1, 2) for seams in prepared.map.seams)])
    assert np.linalg.norm(edges - prepared.map.taxel_points[taxel], axis=1).min() > 0.02
    near = np.linalg.norm(taxels.positions - taxels.positions[taxel], axis=1) < 0.02
    assert (taxels.normals[near] @ taxels.normals[taxel]).min() > np.cos(np.radians(50))


def test_the_ball_is_pressed_in_by_its_depth_and_touches_at_once():
    prepared = forearm()
    beside = beside_ball(prepared)
    taxel = place_to_press(prepared)
    (ball,) = beside.scene.objects
    assert np.allclose(ball.at, over(prepared, np.array([taxel]), BALL - DEPTH)[0])
    session = ControlSetup(beside).session(ControlSettings())
    assert 0.5 < session.pressing < 30.0
    (region,) = session.frame.regions
    assert np.linalg.norm(region.point - prepared.skin.position(prepared.skin.taxel_point(taxel))) < 0.008
    assert prepared.scene.objects == (), "the robot that was given is as it was"


def test_with_the_solvers_contacts_it_presses_too():
    session = ControlSetup(beside_ball(forearm(), model="water-fill")).session(ControlSettings())
    assert session.pressing == pytest.approx(session.frame.pressures @ session.prepared.skin.areas, rel=0.2)


def test_what_is_believed_goes_into_the_session():
    beside = beside_ball(forearm())
    believed = build_map(misplaced(beside.skin, 0.003))
    setup = ControlSetup(beside, believed, SensorEffects(noise=Noise(50.0)), ReadingSettings(estimator="tikhonov"))
    session = setup.session(ControlSettings(law="hybrid"))
    assert session.map is believed is setup.map
    assert session.effects.sensor.noise == Noise(50.0)
    assert session.rules.reading.estimator == "tikhonov"
    assert session.settings.law == "hybrid"
    assert ControlSetup(beside).map is beside.map


def test_a_bare_robot_cannot_be_pressed():
    with pytest.raises(SkinError, match="no skin to press"):
        place_to_press(replace(forearm(), skin=Skin(())))

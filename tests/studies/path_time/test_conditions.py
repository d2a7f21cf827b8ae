"""Conditions of a controller, realised on a robot."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.studies.path_time import conditions
from tactile_maps.studies.path_time.conditions import PITCH, WRENCH_NOISE, Conditions, setup_under
from tactile_maps.studies.testbeds.fixed_ball import with_fixed_ball
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Sampling, SensorEffects
from tests.support.pressed_arm import forearm


@pytest.fixture(scope="module")
def prepared():
    return with_fixed_ball(forearm(), taxel=150)


def test_nominal_skin_has_no_delay_and_no_errors(prepared):
    setup = setup_under(prepared, Conditions(), 0)
    assert setup.believed is None
    assert setup.sensor == SensorEffects(sampling=Sampling(50.0, 0.0))
    assert setup.reading == ReadingSettings()
    assert setup.pressed_elsewhere == 0.0


def test_delay_is_a_number_of_readings(prepared):
    sensor = setup_under(prepared, Conditions(rate=20.0, delay=3), 0).sensor
    assert sensor == SensorEffects(sampling=Sampling(20.0, 0.15))


@pytest.mark.long
def test_misplaced_skin_is_assumed_only_by_the_controller(prepared):
    setups = [setup_under(prepared, Conditions(misplaced=0.003, by=by), 1) for by in ("taxel", "module")]
    moved = [
        np.linalg.norm(setup.map.skin.patches[0].taxels.positions - prepared.skin.patches[0].taxels.positions, axis=1)
        for setup in setups
    ]
    assert all(0.002 < np.median(away) < 0.007 for away in moved)
    assert not np.allclose(*moved)
    assert setups[0].prepared is prepared
    same = Conditions(misplaced=0.003, rate=20.0)
    assert setup_under(prepared, same, 1).believed is setups[0].believed, "made once, whatever it is read by"
    assert setup_under(prepared, same, 2).believed is not setups[0].believed


@pytest.mark.long
def test_map_is_made_by_a_method_or_learned(prepared):
    conformal = setup_under(prepared, Conditions(map="lscm"), 0)
    assert conformal.map.charts[0].method == "lscm"
    assert conformal.map.skin is prepared.skin
    learned = setup_under(prepared, Conditions(map="information-distance"), 0)
    assert len(learned.map.skin) == len(prepared.skin)
    assert "information" in learned.map.charts[0].method
    biased = setup_under(prepared, Conditions(map="information-distance", touch="biased"), 0)
    assert not np.allclose(biased.map.taxel_points, learned.map.taxel_points)
    assert setup_under(prepared, Conditions(map="isomap"), 0).map.charts[0].method == "isomap"


def test_wrong_gain_scales_all_forces_equally(prepared):
    setup = setup_under(prepared, Conditions(gain=1.3), 0)
    believed = setup.map.skin.patches[0].taxels
    true = prepared.skin.patches[0].taxels
    assert np.allclose(believed.areas, 1.3 * true.areas)
    assert np.array_equal(believed.positions, true.positions)


@pytest.mark.long
def test_displaced_sleeve_keeps_its_shape(prepared):
    setup = setup_under(prepared, Conditions(sleeve_shift=0.004, sleeve_turn=math.radians(10)), 0)
    believed = setup.map.skin.patches[0]
    true = prepared.skin.patches[0]
    assert np.median(np.linalg.norm(believed.taxels.positions - true.taxels.positions, axis=1)) > 0.004
    ends = true.surface.faces[:, :2].T
    sides = [np.linalg.norm(np.subtract(*patch.surface.vertices[ends]), axis=1) for patch in (believed, true)]
    assert np.allclose(*sides, atol=1e-12)


def test_lumped_sensor_has_its_own_noise(prepared):
    lumped = setup_under(prepared, Conditions(estimator="lumped"), 0)
    assert lumped.reading == ReadingSettings("lumped", None, WRENCH_NOISE)
    assert setup_under(prepared, Conditions(estimator="tikhonov"), 0).reading == ReadingSettings("tikhonov")


def test_second_finger_presses_elsewhere_and_is_not_counted(prepared):
    setup = setup_under(prepared, Conditions(touched=True), 0)
    ball, finger = (thing.spec for thing in setup.prepared.objects)
    assert np.linalg.norm(np.subtract(finger.path[0][1:], ball.at)) > 0.05
    assert setup.pressed_elsewhere == finger.max_force == 2.0


def test_controller_uses_the_stiffness_of_the_cover():
    hard = Conditions(layer=replace(ElasticLayer(), modulus=10 * ElasticLayer().modulus))
    usual = Conditions().settings(ControlSettings())
    given = hard.settings(ControlSettings())
    assert given.force_gain < usual.force_gain
    assert (given.controller, given.gains) == ("hybrid", "as_given")


def test_skin_is_mounted_on_the_body_instead_of_the_link(monkeypatch):
    monkeypatch.setattr(conditions, "forearm_skin_scene", lambda *_: forearm())
    own, plate = (
        conditions.setup_of("arm", Conditions(body=body), seed=99).prepared for body in (Conditions().body, "plate")
    )
    (placed,), (mounted,) = own.skin.patches, plate.skin.patches
    assert placed is forearm().skin.patches[0]
    assert mounted.link == placed.link
    assert len(mounted.taxels) == pytest.approx(math.pi * 0.045**2 / PITCH**2, rel=0.02)
    assert np.linalg.norm(np.subtract(own.scene.objects[0].at, plate.scene.objects[0].at)) < 0.04

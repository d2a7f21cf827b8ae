"""The simulated skin follows the measured posture; the difference is measured minus simulated pressure."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.simulated_skin import SimulatedSkin, SkinDifference, skin_difference
from tactile_maps.maps.build import build_map
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tests.support.scene_objects import thing
from tests.support.touch import pair, prepared_bar

GAP = 0.03


@cache
def prepared():
    robot, skin = pair()
    return PreparedScene(Scene(name="pair", robot="pair"), robot, skin, build_map(skin))


def confined_pressure(overlap):
    """Return the pressure between equal covers, each with half the overlap: (1 - v) E / ((1 + v) (1 - 2 v)) strain."""
    layer = prepared().scene.layer
    v = layer.poisson
    return (1 - v) * layer.modulus / ((1 + v) * (1 - 2 * v)) * (overlap / 2) / layer.thickness


def frame_of(values, slide, unit=Unit.PASCAL):
    joint = prepared().robot.joints[0].name
    return MeasuredSession(as_measured(prepared())).show(
        Arrived(Reading(0.0, values, unit, joints={joint: slide}), 0.0)
    )


@pytest.mark.long
@pytest.mark.parametrize("overlap", [0.001, 0.002])
def test_covers_in_contact_have_the_pressure_of_elasticity_theory(overlap):
    pressures = SimulatedSkin(prepared()).pressures(np.array([GAP + overlap]))
    assert np.isclose(pressures.max(), confined_pressure(overlap), rtol=1e-6)


@pytest.mark.long
def test_readings_of_a_posture_do_not_depend_on_history():
    skin = SimulatedSkin(prepared())
    first = skin.pressures(np.array([0.032]))
    assert first.max() > 0
    assert not skin.pressures(np.array([0.0])).any()
    assert np.array_equal(skin.pressures(np.array([0.032])), first)


def test_difference_of_a_taxel_with_twice_the_gain_is_its_true_pressure():
    skin = SimulatedSkin(prepared())
    expected = skin.pressures(np.array([0.032]))
    taxel = int(np.argmax(expected))
    same = skin_difference(frame_of(expected, 0.032), expected)
    assert (same.largest, same.rms) == (0.0, 0.0)
    doubled = expected.copy()
    doubled[taxel] *= 2
    found = skin_difference(frame_of(doubled, 0.032), skin.pressures(np.array([0.032])))
    assert np.allclose(found.difference, np.where(np.arange(len(expected)) == taxel, expected, 0.0))
    assert np.isclose(found.largest, expected[taxel])
    assert np.isclose(found.rms, expected[taxel] / np.sqrt(len(expected)))


def test_difference_keeps_its_sign():
    found = SkinDifference(np.array([1.0, 0.0]), np.array([0.0, 3.0]))
    assert found.difference.tolist() == [1.0, -3.0]
    assert found.largest == 3.0


def test_counts_other_skins_and_invalid_postures_are_rejected():
    skin = SimulatedSkin(prepared())
    with pytest.raises(LiveError, match="without a calibration"):
        skin_difference(frame_of(np.zeros(80), 0.0, Unit.COUNTS), np.zeros(80))
    with pytest.raises(LiveError, match="invalid posture"):
        skin.pressures(np.array([np.nan]))
    with pytest.raises(LiveError, match="invalid posture"):
        skin.pressures(np.zeros(2))


def test_object_of_the_scene_presses_at_its_position():
    bar = prepared_bar()
    ball = thing("sphere", at=(0.2, 0.0, 0.039))
    skin = SimulatedSkin(replace(bar, objects=(ball,)))
    pressures = skin.pressures(np.zeros(1))
    (patch,) = bar.skin.patches
    away = np.linalg.norm(patch.taxels.positions - [0.2, 0.0, 0.02], axis=1)
    assert pressures.max() > 0
    assert away[pressures > 0].max() < 0.05
    assert not skin.pressures(np.array([0.5])).any()

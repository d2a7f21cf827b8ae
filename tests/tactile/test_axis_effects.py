"""Effects of the sensor on all channels of three-axis taxels, and the uncertainties that they cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.shear_estimation import ShearEstimator
from tactile_maps.contacts.pipeline import read_contacts
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Skin, taxels_with_axes
from tactile_maps.tactile.sensors.sensor_effects import (
    AxisCrosstalk,
    Misorientation,
    Noise,
    Readout,
    SensorEffects,
    axis_matrices,
)
from tests.support.references import unrolled
from tests.support.scene_objects import thing
from tests.support.sensors import refuses
from tests.support.touch import bar, bar_skin, hold

BOTH = SensorEffects(misorientation=Misorientation(0.05), axis_crosstalk=AxisCrosstalk(0.04))
FRICTION = 0.5


def three_axis(skin: Skin) -> Skin:
    return replace(skin, patches=tuple(replace(one, taxels=taxels_with_axes(one.taxels, 3)) for one in skin.patches))


def matrices(effects: SensorEffects, *, seed: int = 0, skin: Skin | None = None) -> np.ndarray:
    found = axis_matrices(effects, Readout(three_axis(bar_skin(400)) if skin is None else skin, 0.005, seed))
    assert found is not None
    return found


def test_misorientation_rotates_each_frame_by_the_stated_deviation():
    turns = matrices(SensorEffects(misorientation=Misorientation(0.05)))
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), np.tile(np.eye(3), (len(turns), 1, 1)), atol=1e-12)
    assert np.linalg.det(turns) == pytest.approx(1.0)
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert turns[:, one, other].std() == pytest.approx(0.05, rel=0.15)


def test_axis_crosstalk_mixes_channels_by_the_stated_deviation():
    mixed = matrices(SensorEffects(axis_crosstalk=AxisCrosstalk(0.04)))
    assert (mixed[:, range(3), range(3)] == 1.0).all()
    aside = mixed[:, ~np.eye(3, dtype=bool)]
    assert aside.std() == pytest.approx(0.04, rel=0.1)
    assert abs(aside.mean()) < 0.005


def test_matrices_depend_only_on_the_seed_and_leave_one_axis_taxels_unchanged():
    assert np.array_equal(matrices(BOTH), matrices(BOTH))
    assert not np.array_equal(matrices(BOTH), matrices(BOTH, seed=1))
    assert np.array_equal(matrices(BOTH, skin=bar_skin(5)), np.tile(np.eye(3), (5, 1, 1)))
    assert axis_matrices(SensorEffects(noise=Noise()), Readout(bar_skin(5), 0.005, 0)) is None


def sliding(sensor: SensorEffects) -> Simulation:
    """A box on the fixed bar, with gravity turned by 15 degrees."""
    skin = three_axis(bar_skin(finer=2))
    box = thing("box", at=(0.15, 0.0, 0.0298), mass=0.5, friction=FRICTION)
    on = Effects(contact="environment", gravity="on", friction=True, shear=True, sensor=sensor)
    frames = np.tile(np.eye(3), (len(skin), 1, 1))
    simulation = Simulation(bar(hinged=False), skin, on, objects=(box,), frames=lambda: frames)
    simulation._model.opt.gravity[:] = 2.5, 0.0, -9.5
    simulation.step(100, hold(bar(hinged=False), 0.0, 0.0))
    return simulation


@pytest.mark.sampled(1)
@pytest.mark.parametrize("sensor", [BOTH, replace(BOTH, noise=Noise(1e-9))], ids=["alone", "with stages"])
def test_readings_are_the_matrices_times_the_true_channels(sensor):
    true = sliding(SensorEffects())
    pressures = true.sense()
    simulation = sliding(sensor)
    read = np.column_stack([simulation.sense(), simulation.sense_shear()])
    assert simulation.shear.any()
    np.testing.assert_allclose(simulation.shear, true.shear, err_msg="the physics does not depend on the sensor")
    mixed = matrices(sensor, skin=simulation._skin)
    again = np.linalg.solve(mixed, read[:, [1, 2, 0]][:, :, None])[:, :, 0]
    np.testing.assert_allclose(again, np.column_stack([true.shear, pressures]), atol=1e-6, err_msg="calibrated")
    assert not np.allclose(read[:, 0], pressures, rtol=1e-4)
    simulation.use(replace(simulation.effects, sensor=SensorEffects()))
    np.testing.assert_allclose(simulation.sense(), pressures)
    np.testing.assert_allclose(simulation.sense_shear(), true.shear)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("usage", [0.3, 0.9])
@pytest.mark.parametrize("effects", [replace(BOTH, axis_crosstalk=None), replace(BOTH, misorientation=None), BOTH])
def test_uncertainties_cover_the_errors_of_force_shear_and_torque(effects, usage):
    """68 % of the errors of 300 sensors are within the standard uncertainty, 95 % within twice that."""
    flat = unrolled(bar_skin().patches[0].surface, taxels=200)
    map_ = replace(flat, skin=three_axis(flat.skin))
    away = np.linalg.norm(map_.skin.patches[0].taxels.positions - [0.2, 0.0, 0.02], axis=1)
    pressures = np.maximum(0.0, 5e4 * (1 - (away / 0.03) ** 2))
    true = np.column_stack([usage * FRICTION * pressures, 0 * pressures, pressures])
    (region,) = read_contacts(map_, pressures)
    reader = ShearEstimator(map_, FRICTION)
    (exact,) = reader.read(0.0, [region], pressures, true[:, :2])
    reader.axis_errors = effects.axis_errors
    areas = map_.skin.areas[region.taxels]
    axis = taxel_frames(map_)[region.taxels[0], 0]
    errors = []
    for seed in range(300):
        read = np.einsum("nij,nj->ni", matrices(effects, seed=seed, skin=map_.skin), true)
        (found,) = reader.read(0.0, [replace(region)], read[:, 2], read[:, :2])
        force = float(areas @ read[region.taxels, 2]) - region.force
        along = (np.array(found.shear.force) - exact.shear.force) @ axis
        twist = found.shear.torque - exact.shear.torque
        errors.append([force / found.force_error, along / found.shear.force_error, twist / found.shear.torque_error])
    within = np.abs(errors)
    assert ((within < 1).mean(axis=0) > 0.60).all()
    assert ((within < 2).mean(axis=0) > 0.92).all()
    assert ((within < 1).mean(axis=0) < 0.80).all()
    assert set(effects.axis_errors) <= set(found.force_parts)


@pytest.mark.parametrize(
    ("effect", "values"), [(Misorientation, (-0.01, 0.51, np.nan)), (AxisCrosstalk, (-0.01, 0.31, np.inf))]
)
def test_invalid_settings_are_rejected_with_their_range(effect, values):
    refuses(effect, "sd", *values)

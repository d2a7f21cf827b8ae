"""Curves over a whole recording lose no peak, and a summary reads no more than it must."""

from __future__ import annotations

import numpy as np

from tactile_maps.recording.overview.curves import (
    CURVES,
    Curves,
    FrameQuantity,
    QuantityKind,
    envelope,
    joined,
    read_curves,
)
from tactile_maps.recording.player import RecordingPlayer


def test_curves_equal_the_values_of_the_frames(recording):
    shares, pieces = zip(*read_curves(recording), strict=True)
    curves = joined(list(pieces))
    frames = list(RecordingPlayer(recording))
    assert shares[-1] == 1.0
    assert curves.ticks.tolist() == [frame.tick for frame in frames]
    columns = dict(zip(CURVES, curves.values.T, strict=True))
    np.testing.assert_allclose(columns["force"], [sum(region.force for region in frame.regions) for frame in frames])
    assert columns["force"].max() > 0.5
    np.testing.assert_array_equal(columns["peak"], [frame.pressures.max() for frame in frames])
    np.testing.assert_array_equal(columns["speed"], [np.abs(frame.velocity).max() for frame in frames])
    errors = [np.nan if frame.task is None or frame.task.error is None else frame.task.error for frame in frames]
    np.testing.assert_array_equal(columns["error"], errors)


def test_chosen_curves_are_read_in_addition(recording):
    player = RecordingPlayer(recording)
    frames = list(player)
    skin = player.prepared.skin
    taxels = (3, 20, 21, 40)
    areas = tuple(skin.areas[list(taxels)].tolist())
    patch = next(region.at.patch for frame in frames for region in frame.regions)
    chosen = (
        FrameQuantity(QuantityKind.JOINT_POSITION, (1,)),
        FrameQuantity(QuantityKind.JOINT_SPEED, (1,)),
        FrameQuantity(QuantityKind.PEAK_PRESSURE, taxels),
        FrameQuantity(QuantityKind.SKIN_FORCE, taxels, areas),
        FrameQuantity(QuantityKind.CONTACT_FORCE, (patch,)),
        FrameQuantity(QuantityKind.CONTACT_FORCE, (patch + 1,)),
        FrameQuantity(QuantityKind.PEAK_PRESSURE, (len(skin),)),
    )
    curves = joined([piece for _, piece in read_curves(recording, chosen)])
    position, speed, peak, force, contact, elsewhere, nothing = curves.values[:, len(CURVES) :].T
    np.testing.assert_array_equal(position, [frame.posture[1] for frame in frames])
    np.testing.assert_array_equal(speed, [frame.velocity[1] for frame in frames])
    pressures = np.array([frame.pressures[list(taxels)] for frame in frames])
    np.testing.assert_array_equal(peak, pressures.max(axis=1))
    np.testing.assert_allclose(force, pressures @ areas, rtol=1e-12)
    assert force.max() > 0
    on_patch = [sum(region.force for region in frame.regions if region.at.patch == patch) for frame in frames]
    np.testing.assert_allclose(contact, on_patch)
    assert contact.max() > 0.5
    assert not elsewhere.any()
    assert np.isnan(nothing).all()


def test_overlapping_pieces_count_once():
    one = Curves(np.array([1, 3]), np.array([[1.0] * 4, [3.0] * 4]))
    other = Curves(np.array([2, 3]), np.array([[2.0] * 4, [9.0] * 4]))
    assert joined([one, other]).values[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert len(joined([]).ticks) == 0


def test_envelope_keeps_every_extreme_and_leaves_gaps():
    times = np.arange(1000) * 0.005
    values = np.zeros(1000)
    values[[137, 731]] = 6.4, -2.0
    times = np.delete(times, slice(400, 600))
    values = np.delete(values, slice(400, 600))
    low, high = envelope(times, values, np.linspace(0, 5, 51))
    assert high[6] == 6.4
    assert low[36] == -2.0
    assert np.isnan(high[20:30]).all()
    assert np.isfinite(np.r_[high[:20], high[30:]]).all()
    empty = envelope(times, values, np.linspace(10, 11, 5))
    assert np.isnan(empty).all()

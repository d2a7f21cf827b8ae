"""Frames, with their force estimates, come back equal to the last bit."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from app.contacts.force_estimation.estimate import ForceEstimate
from app.contacts.pipeline import ReadingSettings
from app.core.errors import RecordingError
from app.geometry.mesh import SurfacePoint
from app.recording.frame_codec import FRAME_SCHEMA, decode_frame, encode_frame, estimates_from_json, estimates_to_json
from app.session.session import Session
from app.tactile.poke import PokePressed

TOLD = ForceEstimate(
    1 / 3, SurfacePoint(1, 2, (0.1, 0.2, 0.7)), np.array([3, 5]), np.array([0.1, 1 / 3 - 0.1]), float("inf"), 1, 2,
    12.5, 1 / 7, peak=1e4 / 3, mean=1e3 / 3, force_error=1e-3, place_error=2e-3,
)  # fmt: skip
REFUSED = ForceEstimate(2.0, None, refused="No force is felt")


def test_they_read_back_to_the_last_bit():
    plain = ForceEstimate(1.0, None)
    names = [field.name for field in fields(ForceEstimate) if field.name not in ("refused",)]
    same = [name for name in names if np.array_equal(getattr(TOLD, name), getattr(plain, name))]
    assert not same, "each field must differ from its usual value here"
    again = estimates_from_json(json.loads(json.dumps(estimates_to_json({4: TOLD, 9: REFUSED}))))
    assert again.keys() == {4, 9}
    for one, other in ((again[4], TOLD), (again[9], REFUSED)):
        for field in fields(one):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name


@pytest.mark.parametrize("change", [{"force": "much"}, {"at": [1, 2]}, {"taxels": "all"}, {"at": 3}])
def test_damage_is_noticed(change):
    raw = json.loads(json.dumps(estimates_to_json({4: TOLD})))
    raw["4"] |= change
    with pytest.raises((ValueError, TypeError, KeyError, IndexError)):
        estimates_from_json(raw)


@pytest.fixture
def touched(prepared):
    """A frame with a finger and a region."""
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    assert session.frame.pokes
    return session.frame


def test_a_frame_reads_back_equal_to_the_last_bit(touched, prepared):
    again = decode_frame(encode_frame(touched), prepared.skin)
    assert (again.tick, again.time, again.why_limited) == (touched.tick, touched.time, touched.why_limited)
    assert again.timings == touched.timings
    for name in ("posture", "velocity", "pressures"):
        assert getattr(again, name).tobytes() == getattr(touched, name).tobytes()
    for name in ("posture", "stiffness", "damping", "torque"):
        assert getattr(again.command, name).tobytes() == getattr(touched.command, name).tobytes()
    for one, other in zip(again.regions, touched.regions, strict=True):
        assert (one.id, one.force, one.area, one.peak, one.at, one.link) == (
            other.id,
            other.force,
            other.area,
            other.peak,
            other.at,
            other.link,
        )
        assert np.array_equal(one.taxels, other.taxels)
        assert one.torn == other.torn
        assert np.array_equal(one.map_point, other.map_point)
    for one, other in zip(again.pokes, touched.pokes, strict=True):
        assert (one.id, one.at, one.force, one.radius) == (other.id, other.at, other.force, other.radius)


def test_a_damaged_frame_is_refused_by_name(touched, prepared):
    whole = encode_frame(touched)
    absurd = whole[:16] + (2**31 - 1).to_bytes(4, "little") + whole[20:]
    for data in (b"", whole[:10], whole[:-1], whole + b"x", absurd):
        with pytest.raises(RecordingError, match="frame of the recording is damaged"):
            decode_frame(data, prepared.skin)


def test_a_torn_region_stays_torn(touched, prepared):
    torn = replace(touched, regions=tuple(replace(region, torn=True) for region in touched.regions))
    assert all(region.torn for region in decode_frame(encode_frame(torn), prepared.skin).regions)


def test_all_that_is_known_of_a_region_reads_back(touched, prepared):
    region = replace(touched.regions[0], partner=7, split_from=3, merged=(4, 5), place_error=1 / 3)
    assert region.axes.any()
    assert region.mean > 0
    (again,) = decode_frame(encode_frame(replace(touched, regions=(region,))), prepared.skin).regions
    for field in fields(region):
        one, other = getattr(again, field.name), getattr(region, field.name)
        assert np.array_equal(one, other), field.name


def test_objects_and_notes_read_back(touched, prepared):
    poses = np.random.default_rng(0).normal(size=(3, 4, 4))
    frame = replace(touched, objects=poses, notes=("the hand has no skin there",))
    again = decode_frame(encode_frame(frame), prepared.skin)
    assert again.objects.tobytes() == poses.tobytes()
    assert again.notes == frame.notes
    assert [poke.force for poke in again.pokes] == [poke.force for poke in touched.pokes]
    assert [region.id for region in again.regions] == [region.id for region in touched.regions]


@pytest.mark.parametrize("estimator", ["local-nnls", "tikhonov", "lumped"])
def test_estimates_read_back(estimator, prepared):
    session = Session(prepared, reading=ReadingSettings(estimator=estimator))
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(100):
        session.tick()
    frame = session.frame
    assert frame.estimates.keys() == {region.id for region in frame.regions} != set()
    again = decode_frame(encode_frame(frame), prepared.skin)
    assert again.estimates.keys() == frame.estimates.keys()
    for number, one in frame.estimates.items():
        for field in fields(one):
            assert np.array_equal(getattr(again.estimates[number], field.name), getattr(one, field.name)), field.name


def test_the_schema_describes_the_bytes():
    assert "pressures" in FRAME_SCHEMA
    assert "estimates" in FRAME_SCHEMA

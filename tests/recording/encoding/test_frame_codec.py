"""Frames, with their force estimates, come back equal to the last bit."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.estimate import EstimateRefusal, ForceEstimate
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import RegraspState, TaskReport
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure
from tactile_maps.core.errors import RecordingError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.recording.encoding.frame_codec import (
    FRAME_LAYOUT,
    FRAME_SCHEMA,
    POKE,
    REGION,
    FrameText,
    decode_frame,
    encode_frame,
    frame_arrays,
)
from tactile_maps.recording.encoding.frame_schema import PREFIX_BYTES
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.poke import PokePressed, PokeState

BALL = ObjectSpec("ball", "sphere", size=(0.05,))

TOLD = ForceEstimate(
    1 / 3,
    SurfacePoint(1, 2, (0.1, 0.2, 0.7)),
    np.array([3, 5]),
    np.array([0.1, 1 / 3 - 0.1]),
    float("inf"),
    1,
    2,
    12.5,
    1 / 7,
    peak=1e4 / 3,
    mean=1e3 / 3,
    force_error=1e-3,
    place_error=2e-3,
)
REFUSED = ForceEstimate(2.0, None, refused=EstimateRefusal.NO_FORCE)


@pytest.mark.long
def test_limits_and_a_regrasp_read_back_equal(touched, prepared):
    limits = (
        Limit(LimitKind.JOINT_LIMIT, ("elbow", "wrist")),
        Limit(LimitKind.FORCE_GAIN_HELD, value=1 / 3, bound=0.5, period=0.2, delay=0.1),
        Limit(LimitKind.REGRASP_RETURNS, ("hand", "forearm"), cause=RegraspFailure.OBSTACLE),
        Limit(LimitKind.PATH_REFUSED, detail="it circles"),
        Limit(LimitKind.WEAK_DIRECTION, value=0.1, bound=0.02, direction=(0.6, 0.0, -0.8)),
        Limit(LimitKind.JOINT_RESPONSE, ("wrist",), value=8.0, damping_ratio=1.8),
    )
    frame = replace(touched, why_limited=limits, task=TaskReport(regrasp=RegraspState.RETURN))
    again = decode_frame(encode_frame(frame), prepared)
    assert (again.why_limited, again.task) == (limits, frame.task)


def test_estimates_in_a_frame_read_back_to_the_last_bit(touched, prepared):
    plain = ForceEstimate(1.0, None)
    names = [field.name for field in fields(ForceEstimate) if field.name not in ("refused",)]
    same = [name for name in names if np.array_equal(getattr(TOLD, name), getattr(plain, name))]
    assert not same, "each field must differ from its usual value here"
    frame = replace(touched, estimates={4: TOLD, 9: REFUSED})
    again = decode_frame(encode_frame(frame), prepared).estimates
    assert again.keys() == {4, 9}
    for one, other in ((again[4], TOLD), (again[9], REFUSED)):
        for field in fields(one):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name


@pytest.fixture(scope="module")
def touched(prepared):
    """A frame with a finger and a region."""
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    assert session.frame.pokes
    return session.frame


def test_frame_reads_back_equal_to_the_last_bit(touched, prepared):
    again = decode_frame(encode_frame(touched), prepared)
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


def test_frame_of_wrong_length_is_rejected(touched, prepared):
    whole = encode_frame(touched)
    joints = PREFIX_BYTES + 16
    raw = PREFIX_BYTES + 28
    absurd = whole[:joints] + (2**31 - 1).to_bytes(4, "little") + whole[joints + 4 :]
    negative = whole[:raw] + (-1).to_bytes(4, "little", signed=True) + whole[raw + 4 :]
    other_field = b"\x12" + whole[1:]
    for data in (b"", whole[:10], whole[:-1], whole + b"x", absurd, negative, other_field, whole[PREFIX_BYTES:]):
        with pytest.raises(RecordingError, match="/frame"):
            decode_frame(data, prepared)


def test_frame_of_another_robot_skin_or_scene_is_rejected(touched, prepared):
    ball = SceneObject(BALL, primitive_mesh(BALL))
    fewer = replace(prepared.robot, joints=prepared.robot.joints[1:], home=prepared.robot.home[1:])
    for other in (
        replace(prepared, robot=fewer),
        replace(prepared, objects=(ball,)),
        replace(prepared, skin=Skin(prepared.skin.patches[:-1])),
    ):
        with pytest.raises(RecordingError, match="another robot, skin or scene"):
            decode_frame(encode_frame(touched), other)


AT = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
POKED = PokeState(1, AT, 1.0, np.zeros(3), np.zeros(3), 0.01)
WRONG = [replace(AT, patch=-1), replace(AT, patch=99), replace(AT, face=10**9), replace(AT, face=-1)]
WRONG += [replace(AT, weights=weights) for weights in ((np.nan, 0.0, 1.0), (2.0, 2.0, 2.0), (-1.0, 1.0, 1.0))]
NOT_FINITE = (float("nan"), float("inf"))


def change_region(frame, **changes):
    return replace(frame, regions=(replace(frame.regions[0], **changes), *frame.regions[1:]))


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    ("place", "change"),
    [
        *[("regions[0].at", lambda frame, at=at: change_region(frame, at=at)) for at in WRONG],
        *[("pokes[1].at", lambda frame, at=at: replace(frame, pokes=(POKED, replace(POKED, at=at)))) for at in WRONG],
        *[("task.target", lambda frame, at=at: replace(frame, task=TaskReport(at))) for at in WRONG[:4]],
        *[("estimates.4.at", lambda f, at=at: replace(f, estimates={4: replace(TOLD, at=at)})) for at in WRONG[:4]],
        *[("regions.force", lambda frame, bad=bad: change_region(frame, force=bad)) for bad in NOT_FINITE],
        *[
            ("regions.map_point", lambda frame, bad=bad: change_region(frame, map_point=[0.0, bad]))
            for bad in NOT_FINITE
        ],
        *[
            ("pokes.radius", lambda frame, bad=bad: replace(frame, pokes=(replace(POKED, radius=bad),)))
            for bad in NOT_FINITE
        ],
        *[("posture", lambda frame, bad=bad: replace(frame, posture=frame.posture + bad)) for bad in NOT_FINITE],
        *[("velocity", lambda frame, bad=bad: replace(frame, velocity=frame.velocity + bad)) for bad in NOT_FINITE],
        *[("header", lambda frame, bad=bad: replace(frame, time=bad)) for bad in NOT_FINITE],
        ("header", lambda frame: replace(frame, tick=-1)),
        ("estimates.4.force", lambda frame: replace(frame, estimates={4: replace(TOLD, force=float("nan"))})),
        ("estimates.4.forces[1]", lambda f: replace(f, estimates={4: replace(TOLD, forces=[1.0, float("nan")])})),
        ("regions.taxels", lambda frame: change_region(frame, taxels=[10**6])),
        ("regions.taxels", lambda frame: change_region(frame, taxels=[-1])),
        ("touched.1", lambda frame: change_region(frame, touched=0)),
        ("touched.1", lambda frame: change_region(frame, touched=len(frame.regions[0].taxels) + 1)),
        ("task.error", lambda frame: replace(frame, task=TaskReport(error=float("inf")))),
    ],
)
def test_invalid_content_is_rejected_with_its_place(place, change, touched, prepared):
    whole = encode_frame(replace(touched, estimates={4: replace(TOLD, at=AT)}))
    assert decode_frame(whole, prepared).tick == touched.tick
    changed = encode_frame(change(touched))
    with pytest.raises(RecordingError) as refused:
        decode_frame(changed, prepared, file="x.mcap")
    assert place in refused.value.place
    assert refused.value.file == "x.mcap"
    assert refused.value.remedy


@pytest.mark.parametrize("count", [-1, 3, 2**31 - 1])
def test_inconsistent_numbers_of_taxels_are_rejected(count, touched, prepared):
    whole = bytearray(encode_frame(replace(touched, regions=touched.regions[:1])))
    known = len(touched.regions[0].taxels)
    assert count != known
    floats = 6 * len(touched.posture) + len(touched.pressures) + 16 * len(touched.objects)
    row = PREFIX_BYTES + 8 + 8 + 8 * 4 + 8 * floats + POKE.itemsize * len(touched.pokes)
    at = row + REGION.fields["taxels.size"][1]
    assert int.from_bytes(whole[at : at + 4], "little") == known, "the number must be stored here"
    whole[at : at + 4] = count.to_bytes(4, "little", signed=True)
    with pytest.raises(RecordingError, match=r"regions\.taxels\.size"):
        decode_frame(bytes(whole), prepared)


def test_readings_and_commands_may_be_nan(touched, prepared):
    """The last frame before a session stops may hold what stopped it."""
    command = replace(touched.command, torque=touched.command.torque * np.nan)
    frame = replace(touched, pressures=touched.pressures * np.nan, command=command)
    again = decode_frame(encode_frame(frame), prepared)
    assert np.isnan(again.pressures).all()
    assert np.isnan(again.command.torque).all()


def test_all_fields_of_regions_and_fingers_are_encoded():
    elsewhere = {
        ContactRegion: {"taxels", "link", "merged", "touched", "force_parts", "force_limits", "shear"},
        PokeState: set(),
    }
    for kind, record in ((ContactRegion, REGION), (PokeState, POKE)):
        names = {name.partition(".")[0] for name in record.names} - {"taxels"}
        assert names == {field.name for field in fields(kind)} - elsewhere[kind], kind


def test_shear_of_the_skin_and_of_contacts_is_kept_bit_for_bit(touched, prepared):
    rng = np.random.default_rng(0)
    contact = ContactShear((1.0, -2.0, 0.5), 1e-3, 0.8, 0.6, Slip.INCIPIENT, 0.5, estimated=False, force_error=0.1)
    regions = (replace(touched.regions[0], shear=contact), *touched.regions[1:])
    frame = replace(touched, regions=regions, shear=rng.normal(size=(len(prepared.skin), 2)))
    again = decode_frame(encode_frame(frame), prepared)
    assert np.array_equal(again.shear, frame.shear)
    assert again.regions[0].shear == contact
    assert frame_arrays(encode_frame(frame)).text == frame_arrays(encode_frame(replace(frame, shear=None))).text
    with pytest.raises(RecordingError, match="do not add up"):
        decode_frame(encode_frame(replace(frame, shear=frame.shear[1:])), prepared)


def test_torn_region_is_restored_as_torn(touched, prepared):
    torn = replace(touched, regions=tuple(replace(region, torn=True) for region in touched.regions))
    assert all(region.torn for region in decode_frame(encode_frame(torn), prepared).regions)


def test_all_fields_of_a_region_are_restored(touched, prepared):
    region = replace(
        touched.regions[0],
        partner=7,
        split_from=3,
        merged=(4, 5),
        place_error=1 / 3,
        force_parts={"noise": 0.1, "ring": 1 / 3, "contact_model": float("inf")},
        force_limits={"noise": 0.2, "ring": 2 / 3, "contact_model": float("inf")},
    )
    assert region.link_axes.any()
    assert region.mean > 0
    (again,) = decode_frame(encode_frame(replace(touched, regions=(region,))), prepared).regions
    for field in fields(region):
        one = getattr(again, field.name)
        other = getattr(region, field.name)
        assert np.array_equal(one, other), field.name


NOTES = (
    ContactNote(ContactNoteKind.OUTSIDE_SKIN, ("hand",)),
    ContactNote(ContactNoteKind.UNSTABLE, ("hand", "ball"), 1e5, 2e4, 1e-4),
    ContactNote(ContactNoteKind.BENT_SKIN, ("ball", "hand"), ratio=0.97),
)


def test_objects_and_notes_read_back(touched, prepared):
    poses = np.random.default_rng(0).normal(size=(3, 4, 4))
    frame = replace(touched, objects=poses, notes=NOTES)
    balls = (SceneObject(BALL, primitive_mesh(BALL)),) * 3
    again = decode_frame(encode_frame(frame), replace(prepared, objects=balls))
    assert again.objects.tobytes() == poses.tobytes()
    assert again.notes == frame.notes
    assert [poke.force for poke in again.pokes] == [poke.force for poke in touched.pokes]
    assert [region.id for region in again.regions] == [region.id for region in touched.regions]


@pytest.mark.long
@pytest.mark.parametrize("estimator", ["local-nnls", "tikhonov", "lumped"])
def test_estimates_read_back(estimator, prepared):
    session = Session(prepared, reading=ReadingSettings(estimator=estimator))
    session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
    for _ in range(100):
        session.tick()
    frame = session.frame
    assert frame.estimates.keys() == {region.id for region in frame.regions} != set()
    again = decode_frame(encode_frame(frame), prepared)
    assert again.estimates.keys() == frame.estimates.keys()
    for number, one in frame.estimates.items():
        for field in fields(one):
            assert np.array_equal(getattr(again.estimates[number], field.name), getattr(one, field.name)), field.name


def test_schema_matches_the_encoded_bytes(touched):
    schema = json.loads(FRAME_LAYOUT)
    header = np.dtype([(name, f"<{kind}") for name, kind in schema["header"].items()])
    (sizes,) = np.frombuffer(encode_frame(touched), header, count=1, offset=PREFIX_BYTES)
    assert [sizes[name] for name in ("tick", "taxels", "regions")] == [100, len(touched.pressures), 1]
    assert FRAME_LAYOUT.encode() in FRAME_SCHEMA, "it is in the file"
    assert set(schema["arrays"]) >= {"posture", "pressures", "command.torque", "objects"}
    assert "link_axes: float64[2, 3]" in schema["region"]
    assert set(schema["text"]["properties"]) == {field.name for field in fields(FrameText)}

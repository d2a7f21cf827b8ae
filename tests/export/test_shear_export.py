"""Shear of taxels and the wrenches of contacts are in every export of a three-axis skin."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactile_maps.core.assets import asset
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.export.contact_messages import contact_wrench, contacts_json, link_wrench
from tactile_maps.export.export import ExportOptions, export_recording
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.recording.encoding import viewer_messages
from tactile_maps.recording.overview.curves import CURVES, FrameQuantity, QuantityKind, joined, read_curves
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.skin.model.skin import Skin, taxels_with_axes
from tactile_maps.tactile.press import press_skin
from tests.export.test_rosbag import messages
from tests.recording.encoding.test_viewer_messages import decoded
from tests.support.touch import bar_skin, prepared_bar

PRESSED = press_skin(bar_skin(), bar_skin().taxel_point(30), force=3.0)
SHEAR = np.column_stack([0.3 * PRESSED, -0.2 * PRESSED])


@pytest.fixture(scope="module")
def player(tmp_path_factory):
    """Four readings of a real skin with three axes: a force of 3 N, and shear from the second on."""
    (patch,) = bar_skin().patches
    skin = Skin((replace(patch, taxels=taxels_with_axes(patch.taxels, 3)),))
    session = MeasuredSession(as_measured(replace(prepared_bar(), skin=skin, map=build_map(skin))))
    path = tmp_path_factory.mktemp("sheared") / "felt.mcap"
    with Recorder(session.prepared, path, measured="udp://127.0.0.1:9870") as recorder:
        for number in range(4):
            reading = Reading(0.02 * number, PRESSED, Unit.PASCAL, shear=SHEAR if number else None)
            recorder.write(session.show(Arrived(reading, reading.time)), session.inputs)
    return RecordingPlayer(path)


def expected_force(player):
    """Return the sum of the forces of all taxels in the frame of the link."""
    frames = taxel_frames(player.prepared.map)
    areas = player.prepared.skin.areas
    tractions = np.column_stack([SHEAR, -PRESSED])
    return np.einsum("n,nk,nkj->j", areas, tractions, frames)


def test_tables_contain_shear_of_frames_and_wrenches_of_contacts(player, tmp_path):
    export_recording(player, tmp_path / "felt.npz", to="npz")
    with np.load(tmp_path / "felt.npz") as arrays:
        assert np.isnan(arrays["pressures.t1_shear_Pa"][0]).all()
        for axis in (1, 2):
            found = arrays[f"pressures.t{axis}_shear_Pa"][1:]
            assert np.array_equal(found, np.broadcast_to(SHEAR[:, axis - 1], (3, 60)))
            assert np.array_equal(arrays[f"pressures.t{axis}_raw_Pa"][1:], found)
        wrench = [arrays[f"contacts.force_{axis}_N"][-1] for axis in "xyz"]
        assert arrays["contacts.slip"][-1] in ("sticking", "incipient slip", "sliding")
        assert np.isnan(arrays["contacts.force_x_N"][0])
    assert np.allclose(wrench, expected_force(player), rtol=0.03)
    assert np.isclose(np.linalg.norm(wrench), 3 * np.sqrt(1 + 0.3**2 + 0.2**2), rtol=0.05)


def test_lerobot_has_three_numbers_for_each_taxel(player, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    pytest.importorskip("av")
    export_recording(player, tmp_path / "set", to="lerobot")
    info = json.loads((tmp_path / "set" / "meta" / "info.json").read_text())["features"]["observation.tactile3"]
    assert info["shape"] == [60, 3]
    assert np.allclose(info["info"]["tangents"], taxel_frames(player.prepared.map)[:, 0], atol=1e-6)
    rows = parquet.read_table(tmp_path / "set" / "data" / "chunk-000" / "file-000.parquet")
    found = np.array(rows["observation.tactile3"].to_pylist()[-1])
    assert np.array_equal(found, np.column_stack([PRESSED, SHEAR]).astype(np.float32))


def test_bag_has_shear_and_wrenches_that_contain_it(player, tmp_path):
    pytest.importorskip("rosbags")
    export_recording(player, tmp_path / "bag", to="rosbag2")
    found = messages(tmp_path / "bag")
    assert len(found["/skin/shear"]) == 3
    assert len(found["/skin/contacts"]) == 4
    _, shear = found["/skin/shear"][-1]
    assert [one.size for one in shear.layout.dim] == [60, 2]
    assert np.array_equal(shear.data.reshape(60, 2), SHEAR.astype(np.float32))
    _, message = found["/skin/contacts"][-1]
    (contact,) = message.contacts
    force = contact.wrench.force
    assert contact.link == "bar"
    assert np.allclose([force.x, force.y, force.z], expected_force(player), rtol=0.03)


def test_curves_over_the_recording_have_shear_and_friction(player):
    chosen = FrameQuantity(QuantityKind.SHEAR_FORCE), FrameQuantity(QuantityKind.FRICTION_IN_USE)
    curves = joined([piece for _, piece in read_curves(player.path, chosen)])
    force, friction = curves.values[:, len(CURVES) :].T
    shears = [[one.shear for one in frame.regions if one.shear] for frame in player]
    assert np.allclose(force, [sum(np.linalg.norm(one.force) for one in found) for found in shears])
    assert np.allclose(friction, [max((one.usage for one in found), default=0.0) for found in shears])
    assert force[-1] > 0.5


def test_lerobot_windows_have_shear_of_each_reading(player, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    pytest.importorskip("av")
    export_recording(player, tmp_path / "set", to="lerobot", options=ExportOptions(fps=25))
    features = json.loads((tmp_path / "set" / "meta" / "info.json").read_text())["features"]
    rows = parquet.read_table(tmp_path / "set" / "data" / "chunk-000" / "file-000.parquet")
    windows = np.array(rows["observation.tactile3_window"].to_pylist())
    assert features["observation.tactile3_window"]["shape"] == list(windows.shape[1:]) == [2, 60, 3]
    assert np.array_equal(windows[-1, -1], np.column_stack([PRESSED, SHEAR]).astype(np.float32))
    assert np.isnan(windows[0, 0, :, 1:]).all(), "the first reading has no shear"
    assert np.array_equal(windows[..., 0], np.array(rows["observation.tactile_window"].to_pylist()))
    stats = json.loads((tmp_path / "set" / "meta" / "stats.json").read_text())
    assert np.shape(stats["observation.tactile3_window"]["max"]) == (2, 60, 3)


def test_arrows_of_viewers_show_the_whole_force(player):
    frame = player.frame(3)
    (region,) = frame.regions
    np.testing.assert_allclose(region.force_vector, expected_force(player), rtol=0.03, atol=0.02)
    update = decoded(player.path)["/contacts"][-1][1]
    arrow = update.entities[0].arrows[0]
    turn = Rotation.from_quat([getattr(arrow.pose.orientation, axis) for axis in "xyzw"])
    step = (arrow.shaft_length + arrow.head_length) * turn.apply([1.0, 0.0, 0.0])
    tail = np.array([getattr(arrow.pose.position, axis) for axis in "xyz"])
    np.testing.assert_allclose(tail + step, region.link_position, atol=1e-9)
    np.testing.assert_allclose(step, viewer_messages._METRES_A_NEWTON * region.force_vector, atol=1e-9)


def test_live_message_of_contacts_has_the_wrenches_of_the_bag(player):
    frame = player.frame(3)
    message = contacts_json(frame, player.prepared.skin, 3_000_000_007)
    assert message["header"]["stamp"] == {"sec": 3, "nanosec": 7}
    ((contact,), (link,)) = message["contacts"], message["links"]
    (region,) = frame.regions
    for found, wrench in ((contact, contact_wrench(region)), (link, link_wrench([region]))):
        read = [found["wrench"][part][axis] for part in ("force", "torque") for axis in "xyz"]
        np.testing.assert_allclose(read, wrench.wrench)
        np.testing.assert_allclose(found["covariance"], wrench.covariance.ravel())
    assert contact["link"] == link["link"] == "bar"
    uncalibrated = replace(frame, measured=replace(frame.measured, units=ReadingUnits.COUNTS))
    counts = contacts_json(uncalibrated, player.prepared.skin, 0)
    assert counts["contacts"][0]["wrench"]["force"] == {"x": None, "y": None, "z": None}
    json.dumps(message, allow_nan=False)


def test_table_of_taxels_contains_the_directions_of_shear(player, tmp_path):
    export_recording(player, tmp_path / "felt.npz", to="npz")
    frames = taxel_frames(player.prepared.map)
    with np.load(tmp_path / "felt.npz") as arrays:
        found = [[arrays[f"taxels.{name}_{axis}"] for axis in "xyz"] for name in ("t1", "t2", "normal")]
    assert np.allclose(np.transpose(found, (2, 0, 1)), frames, atol=1e-9)


def test_guide_names_the_pressure_columns_of_csv_correctly(player, tmp_path):
    export_recording(player, tmp_path / "touch", to="csv")
    page = asset("guide", "data.md").read_text(encoding="utf8")
    header, *rows = csv.reader((tmp_path / "touch" / "pressures.csv").read_text(encoding="utf8").splitlines())
    (prefix,) = re.findall(r'filter\(like="(.*?)"\)', page)
    named = [number for number, column in enumerate(header) if prefix in column]
    assert [header[number] for number in named] == [f"pressure_Pa.taxel_{taxel}" for taxel in range(len(PRESSED))]
    assert "`pressure_Pa.taxel_12`" in page
    assert [float(rows[-1][number]) for number in named] == PRESSED.tolist()

"""A recording of a real skin is exported with the sender's times, the values as sent, and units that are true."""

from __future__ import annotations

import csv
import json
from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.core.errors import ExportError
from tactile_maps.export.export import export_recording
from tactile_maps.export.tables import episodes
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.tactile.press import press_skin
from tests.support.touch import bar_skin, prepared_bar

TIMES = (70.0, 70.02, 70.041, 70.06, 70.08, 75.0, 75.02)
"""Times of the sender's clock [s]: about 50 readings per second, and a gap."""
SKIN = bar_skin()
PRESSED = np.rint(20 + 0.01 * press_skin(SKIN, SKIN.taxel_point(30), force=3.0))


def recorded(path, *, weigh_at=None, unit=Unit.COUNTS):
    session = MeasuredSession(as_measured(prepared_bar()))
    session.tare(1)
    with Recorder(session.prepared, path, measured="udp://127.0.0.1:9870") as recorder:
        recorder.write(session.frame, session.inputs)
        for number, time in enumerate(TIMES):
            if number == weigh_at:
                session.weights.weigh(3.0 / 9.80665)
            values = PRESSED if number else np.full(60, 20.0)
            reading = Reading(time, values, unit, sequence=4 + number)
            recorder.write(session.show(Arrived(reading, time)), session.inputs)
    return RecordingPlayer(path)


@pytest.fixture(scope="module")
def player(tmp_path_factory):
    return recorded(tmp_path_factory.mktemp("measured") / "felt.mcap")


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Calibrated by a weight after four readings."""
    return recorded(tmp_path_factory.mktemp("measured") / "changed.mcap", weigh_at=4)


def exported(player, path, to):
    export_recording(player, path, to=to)
    return path


def _rows(folder, table):
    return list(csv.DictReader((folder / f"{table}.csv").read_text().splitlines()))


def test_csv_contains_counts_and_their_send_times(player, tmp_path):
    folder = exported(player, tmp_path / "out", "csv")
    rows = _rows(folder, "pressures")[1:]
    assert [float(row["sent_s"]) for row in rows] == list(TIMES)
    assert [int(row["sequence"]) for row in rows] == list(range(4, 11))
    raw = [[float(row[f"raw_counts.taxel_{taxel}"]) for taxel in range(60)] for row in rows]
    assert np.array_equal(raw[1:], [PRESSED] * 6)
    shown = [float(rows[3][f"reading_counts.taxel_{taxel}"]) for taxel in range(60)]
    assert np.allclose(shown, PRESSED - 20)
    for path in folder.iterdir():
        heads = path.read_text().splitlines()[0].split(",")
        assert not [head for head in heads if head.endswith(("_Pa", "_kPa"))]
    contact = next(iter(_rows(folder, "contacts")))
    assert (contact["force_N"], contact["force_error_N"]) == ("nan", "nan")
    assert np.isclose(float(contact["peak_counts"]), PRESSED.max() - 20)
    assert {row["force_N"] for row in _rows(folder, "events")} == {"nan"}


def test_calibration_during_a_recording_gives_columns_in_both_units(changed, tmp_path):
    arrays = np.load(exported(changed, tmp_path / "out.npz", "npz"))
    known = np.isfinite(arrays["pressures.pressure_Pa"]).all(axis=1)
    assert known.tolist() == [False] * 5 + [True] * 3
    assert np.array_equal(known, ~np.isfinite(arrays["pressures.reading_counts"]).any(axis=1))
    assert np.isnan(arrays["images.image_kPa"][1]).any()
    np.testing.assert_allclose(np.nanmax(arrays["images.image_counts"][2]), PRESSED.max() - 20, rtol=0.1)
    forces = arrays["contacts.force_N"]
    assert np.isnan(forces[:3]).all()
    assert np.allclose(forces[3:], 3.0, rtol=0.05)


def test_parquet_names_the_taxels_that_were_sent(player, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (extra export)")
    table = parquet.read_table(exported(player, tmp_path / "out", "parquet") / "pressures.parquet")
    field = table.schema.field("raw_counts")
    assert field.metadata[b"labels"].decode().split("\n")[7] == "taxel_7"
    assert np.array_equal(table["raw_counts"][3].as_py(), PRESSED)


def test_silence_ends_an_episode_and_a_gap_of_ticks_does_not(player):
    assert [(one.first, one.frames) for one in episodes(player)] == [(0, 6), (6, 2)]


def test_lerobot_has_rows_at_equal_steps_in_counts(player, changed, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (extra export)")
    pytest.importorskip("av", reason="PyAV is not installed (extra export)")
    folder = exported(player, tmp_path / "set", "lerobot")
    info = json.loads((folder / "meta/info.json").read_text())
    assert (info["fps"], info["tactile_maps"]["tactile_unit"]) == (50, "counts")
    rows = parquet.read_table(folder / "data/chunk-000/file-000.parquet").to_pydict()
    assert len(rows["index"]) == info["total_frames"] == 7
    assert rows["episode_index"] == [0] * 5 + [1] * 2
    for (a, one), (b, other) in pairwise(zip(rows["timestamp"], rows["episode_index"], strict=True)):
        assert one != other or np.isclose(b - a, 0.02)
    assert np.allclose(rows["observation.tactile"][-1], PRESSED - 20)
    stats = json.loads((folder / "meta/stats.json").read_text())["observation.tactile"]
    assert stats["count"] == [7]
    assert np.isclose(stats["max"][30], PRESSED[30] - 20)
    with pytest.raises(ExportError, match="some readings are counts and others pressures"):
        exported(changed, tmp_path / "other", "lerobot")


@pytest.mark.long
@pytest.mark.parametrize("to", ["csv", "parquet", "npz", "hdf5", "lerobot", "rosbag2"])
def test_skin_without_joints_is_exported(tmp_path, to):
    bare = as_measured(prepared_bar(hinged=False))
    session = MeasuredSession(bare)
    with Recorder(bare, tmp_path / "felt.mcap", measured="a file") as recorder:
        for number in range(3):
            frame = session.show(Arrived(Reading(0.01 * number, PRESSED), 0.01 * number))
            recorder.write(frame, session.inputs)
    assert len(frame.posture) == 0
    exported(RecordingPlayer(tmp_path / "felt.mcap"), tmp_path / "out", to)


def test_skin_that_sends_pressure_needs_no_counts(tmp_path):
    arrays = np.load(exported(recorded(tmp_path / "felt.mcap", unit=Unit.PASCAL), tmp_path / "out.npz", "npz"))
    assert "pressures.reading_counts" not in arrays
    assert np.array_equal(arrays["pressures.raw_Pa"][-1], PRESSED)

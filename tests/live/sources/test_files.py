"""Recorded readings are read as others write them, at their times, damaged rows and all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError, TactileMapsError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, SourceEndedError, Unit
from tactile_maps.live.sources.files import FileSource, read_recording, read_table, read_text
from tactile_maps.live.sources.open import SourceOptions, open_source
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tests.support.touch import prepared_bar

CYSKIN = Path(__file__).parents[4] / "shared" / "data" / "cyskin_acquisition"
TABLE = """# unit: kPa
time,sequence,87012,87013,joint:elbow
0.0,0,1.5,2.5,0.1
0.01,1,,3.5,
0.02,2,x,1,0.2
0.03
0.04,4,1,2,0.3
"""


def rows(path, read):
    return list(read(path))


def test_csv_table_with_gaps_and_invalid_rows_is_read(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text(TABLE)
    first, second, third, fourth, last = rows(path, read_table)
    assert (first.unit, first.ids.tolist(), first.values.tolist()) == (Unit.KILOPASCAL, [87012, 87013], [1.5, 2.5])
    assert (second.ids.tolist(), dict(second.joints), second.sequence) == ([87013], {}, 1)
    assert [type(third), third.place, type(fourth), fourth.place] == [
        MalformedReadingError,
        "line 5",
        MalformedReadingError,
        "line 6",
    ]
    assert (last.time, dict(last.joints)) == (0.04, {"elbow": 0.3})


def test_table_may_be_utf_16(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_bytes("time,14.3,joint:Schulter außen\n0,2,0.1\n".encode("utf-16"))
    (reading,) = rows(path, read_table)
    assert (reading.values.tolist(), dict(reading.joints)) == ([2.0], {"Schulter außen": 0.1})


def test_columns_may_be_modules_and_channels(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text("14.3,time,14.10\n1,0,2\n")
    (reading,) = rows(path, read_table)
    assert reading.channels.tolist() == [[14, 3], [14, 10]]
    assert reading.values.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("name", "sent", "seconds"),
    [
        ("Timestamp", "1700000000.25", 1700000000.25),
        ("timestamp", "1700000000250", 1700000000.25),
        ("stamp", "1700000000250000000", 1700000000.25),
        ("t", "12.5", 12.5),
        ("time_s", "3e12", 3e12),
        ("time [ms]", "250", 0.25),
        ("t_ns", "5e8", 0.5),
    ],
)
def test_time_has_other_names_and_units(tmp_path, name, sent, seconds):
    path = tmp_path / "readings.csv"
    path.write_text(f"{name},3\n{sent},1\n")
    (reading,) = rows(path, read_table)
    assert reading.time == pytest.approx(seconds, rel=1e-15)


@pytest.mark.parametrize(("component", "values"), [("z", [4.0, -2.0]), ("norm", [5.0, 2.0]), ("x", [3.0, 0.0])])
def test_chosen_column_of_three_per_taxel_is_its_value(tmp_path, component, values):
    path = tmp_path / "readings.csv"
    header = "time,8_fx,8_fy,8_fz,l:9.x,l:9.y,l:9.z".replace("l:", "")
    path.write_text(f"# component: {component}\n{header}\n0,3,0,4,0,0,-2\n1,3,0,4,,,\n")
    first, second = rows(path, read_table)
    assert (first.ids.tolist(), first.values.tolist()) == ([8, 9], values)
    assert second.ids.tolist() == [8]


def test_three_columns_are_pressure_and_shear_and_a_single_one_is_pressure(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text("# component: xyz\ntime,8_x,8_y,8_z,9\n0,3,1,4,5\n1,3,,4,\n2,,,,6\n")
    first, second, third = rows(path, read_table)
    assert (first.ids.tolist(), first.values.tolist()) == ([9, 8], [5.0, 4.0])
    assert np.array_equal(first.shear, [[np.nan, np.nan], [3.0, 1.0]], equal_nan=True)
    assert np.array_equal(second.shear, [[3.0, np.nan]], equal_nan=True)
    assert (third.ids.tolist(), third.values.tolist()) == ([9], [6.0])


@pytest.mark.parametrize("separator", [";", "\t"])
def test_cells_may_be_separated_by_semicolons_or_tabs(tmp_path, separator):
    path = tmp_path / "readings.csv"
    path.write_text("time,3,4\n0.5,1,\n".replace(",", separator))
    (reading,) = rows(path, read_table)
    assert (reading.time, reading.ids.tolist(), reading.values.tolist()) == (0.5, [3], [1.0])
    path.write_text("time;3\n0,5;1\n")
    (error,) = rows(path, read_table)
    assert str(error).startswith("line 2: the table uses decimal commas (found: 0,5). Replace them by decimal points")


def test_columns_may_be_ids_with_their_link(tmp_path):
    path = tmp_path / "readings.csv"
    path.write_text("time,l_hand:3,base/skin.1:3\n0,1,\n1,2,5\n")
    first, second = rows(path, read_table)
    assert (first.ids.tolist(), first.links) == ([3], ("l_hand",))
    assert (second.ids.tolist(), second.links) == ([3, 3], ("l_hand", "base/skin.1"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,l:3,4\n0,1,2\n", "only some ids have a link .found: 1 of 2"),
        ("time,l:3,l:03\n0,1,2\n", "a taxel has two columns .found: l:03"),
        ("", "the table is empty"),
        ("0,1.5,2\n0.1,2,3\n", "has no header .found: 0.. Add a first line"),
        ("time,stamp,3\n0,0,1\n", "several columns state the time .found: time, stamp"),
        ("time,3_x,3_y,3_z\n", "need a component.*# component: z"),
        ("# component: w\ntime,3_x,3_y,3_z\n", "need a component .found: w"),
        ("# component: z\ntime,3_x,3_z\n", "column is missing: 3_y .found: time, 3_x, 3_z"),
        ("a,b\n", "column is missing: time .found: a, b"),
        ("time,pressure\n0,1\n", "unknown column .found: pressure"),
        (f"time,{2**64}\n0,1\n", "unknown column .found: 18446744073709551616"),
        (f"time,3.{'9' * 5000}\n0,1\n", "unknown column .found: 3.999"),
        ("time,3,3\n", "a taxel has two columns"),
        ("time,3,1.3\n", "taxels are named in two ways"),
        ("# unit: psi\ntime,3\n", "unknown unit"),
        ("time,3\n", "contains no readings"),
    ],
)
def test_contradictory_header_is_rejected(tmp_path, text, said):
    path = tmp_path / "readings.csv"
    path.write_text(text)
    with pytest.raises(LiveError, match=said) as caught:
        FileSource(path, read_table).open()
    assert str(caught.value.file) == str(path)


def test_missing_or_binary_file_is_rejected(tmp_path):
    (tmp_path / "noise.csv").write_bytes(b"\xff\xfe\x00\x81" * 20)
    for name in ("none.csv", "none.txt", "noise.csv", "none.mcap"):
        with pytest.raises(TactileMapsError, match="none|noise"):
            open_source(str(tmp_path / name)).open()


def test_parquet_table_is_read(tmp_path):
    pyarrow = pytest.importorskip("pyarrow", reason="an extra of 100 MB")
    parquet = pytest.importorskip("pyarrow.parquet", reason="an extra of 100 MB")
    table = pyarrow.table(
        {"time": [0.0, 0.1, 0.2], "5": pyarrow.array([1, None, 3], pyarrow.int16()), "6": [1.5, 2.5, float("inf")]}
    ).replace_schema_metadata({"unit": "Pa"})
    path = tmp_path / "readings.parquet"
    parquet.write_table(table, path)
    first, second, third = rows(path, read_table)
    assert (first.unit, first.values.tolist(), second.ids.tolist()) == (Unit.PASCAL, [1.0, 1.5], [6])
    assert isinstance(third, MalformedReadingError)
    path.write_bytes(path.read_bytes()[:-9])
    with pytest.raises(LiveError, match="cannot be read as Parquet"):
        rows(path, read_table)


def test_cyskin_acquisition_text_is_read(tmp_path):
    path = tmp_path / "sample.txt"
    path.write_text("19696 19697 \n0 0.600000 0 6 \n1 0.700000 1 x \n2 0.8 3 4\n")
    first, second, third = rows(path, read_text)
    assert (first.time, first.sequence, first.ids.tolist(), first.values.tolist()) == (0.6, 0, [19696, 19697], [0, 6])
    assert isinstance(second, MalformedReadingError)
    assert third.unit is Unit.COUNTS
    path.write_text("time value\n")
    with pytest.raises(LiveError, match="one hardware id"):
        rows(path, read_text)


@pytest.mark.skipif(not CYSKIN.is_dir(), reason="CySkin's recordings are not in shared/data")
def test_recorded_samples_of_a_real_skin_are_read_completely():
    path = next(iter(sorted(CYSKIN.glob("3_finger/*.txt"))))
    readings = rows(path, read_text)
    assert len(readings) == 30
    assert all(isinstance(one, Reading) and len(one.values) == 716 for one in readings)


def test_own_recording_can_be_played_as_readings(tmp_path):
    session = Session(prepared_bar())
    session.press(session.prepared.skin.taxel_point(30))
    path = tmp_path / "own.mcap"
    frames = []
    with Recorder(session.prepared, path) as recorder:
        for _ in range(30):
            frames.append(session.tick())
            recorder.write(frames[-1], session.inputs)
    readings = rows(path, read_recording)
    assert len(readings) == 30
    assert np.array_equal(readings[-1].values, frames[-1].pressures)
    assert list(readings[-1].joints.values()) == frames[-1].posture.tolist()
    path.write_bytes(path.read_bytes()[:50])
    with pytest.raises(TactileMapsError):
        open_source(str(path), SourceOptions()).open()


def test_file_is_played_at_its_speed(tmp_path):
    path = tmp_path / "readings.csv"
    waited = []
    path.write_text("time,3\n5.0,1\n5.5,2\n6.0,3\n")
    source = FileSource(path, read_table, speed=2.0, clock=lambda: sum(waited), wait=waited.append)
    source.open()
    taken = []
    for _ in range(20):
        try:
            if (reading := source.receive(0.125)) is not None:
                taken.append((reading.time, sum(waited)))
        except SourceEndedError:
            break
    assert taken == [(5.0, 0.0), (5.5, 0.25), (6.0, 0.5)]
    assert max(waited) == 0.125

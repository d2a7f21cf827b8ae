"""Every format of tables gives back all that the recording holds, to the last bit, by the format's own reader."""

from __future__ import annotations

import csv
from contextlib import ExitStack

import numpy as np
import pytest

from tactile_maps.export.export import ExportOptions, export_recording
from tactile_maps.export.sinks import Hdf5Sink
from tactile_maps.export.tables import JOINT_COLUMNS, column_unit, taxel_labels
from tactile_maps.maps.model.tactile_image import TactileImage


def read_csv(path):
    tables = {}
    for file in path.iterdir():
        with file.open(encoding="utf8", newline="") as stream:
            head, *rows = list(csv.reader(stream))
        columns = {name: [row[place] for row in rows] for place, name in enumerate(head)}
        tables[file.stem] = {}
        for name, values in columns.items():
            column, _, _ = name.partition(".")
            tables[file.stem].setdefault(column, []).append(values)
        tables[file.stem] = {
            name: values[0] if len(values) == 1 else list(zip(*values, strict=True))
            for name, values in tables[file.stem].items()
        }
    return tables


def read_parquet(path):
    parquet = pytest.importorskip("pyarrow.parquet")
    return {file.stem: parquet.read_table(file).to_pydict() for file in path.iterdir()}


def read_npz(path):
    found = {}
    with np.load(path, allow_pickle=False) as arrays:
        for key in arrays.files:
            table, _, column = key.partition(".")
            found.setdefault(table, {})[column] = arrays[key]
    return found


def read_hdf5(path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path) as file:
        return {
            table: {name: data.asstr()[:] if data.dtype == object else data[:] for name, data in group.items()}
            for table, group in file.items()
        }


READERS = {"csv": read_csv, "parquet": read_parquet, "npz": read_npz, "hdf5": read_hdf5}


@pytest.fixture(scope="module", params=READERS)
def tables(request, player, tmp_path_factory):
    target = tmp_path_factory.mktemp(request.param) / "out"
    export_recording(player, target, to=request.param, options=ExportOptions(image_width=24))
    return READERS[request.param](target)


def numbers(values):
    return np.array(values, dtype=np.float64)


def test_hdf5_has_dimension_scales_and_units(player, frames, tmp_path):
    """Tables have the same scales as in netCDF, so xarray opens them with named coordinates."""
    h5py = pytest.importorskip("h5py")
    export_recording(player, tmp_path / "out.h5", to="hdf5", options=ExportOptions(image_width=24))
    with h5py.File(tmp_path / "out.h5") as file:

        def scales(dataset):
            return [dataset.dims[axis][0].name.rpartition("/")[2] for axis in range(dataset.ndim)]

        for table, column, expected, unit in (
            ("pressures", "pressure_Pa", ["time_s", "taxel"], "Pa"),
            ("frames", "position", ["time_s", "joint"], "rad"),
            ("frames", "command_stiffness", ["time_s", "joint"], "N m/rad"),
            ("frames", "tick", ["time_s"], None),
            ("images", "image_kPa", ["time_s", "pixel_row", "pixel_column"], "kPa"),
            ("contacts", "area_m2", ["time_s"], "m2"),
            ("contacts", "force_error_N", ["time_s"], "N"),
            ("events", "duration_s", ["time_s"], "s"),
            ("taxels", "map_x_m", ["taxel"], "m"),
            ("joints", "lower", ["joint"], "rad"),
            ("episodes", "frames", ["episode"], None),
        ):
            assert scales(file[table][column]) == expected
            assert file[table][column].attrs.get("units") == unit
        for table in file.values():
            for name, data in table.items():
                assert data.is_scale or all(len(data.dims[axis]) == 1 for axis in range(data.ndim)), name
                lengths = [data.dims[axis][0].shape[0] for axis in range(data.ndim) if not data.is_scale]
                assert lengths == list(data.shape if not data.is_scale else ())
        assert file["pressures/taxel"].asstr()[:].tolist() == taxel_labels(player.prepared.skin)
        assert file["frames/joint"].asstr()[:].tolist() == [joint.name for joint in player.prepared.robot.joints]
        assert file["pressures/time_s"].attrs["units"] == "s"
        np.testing.assert_array_equal(file["pressures/time_s"], [frame.time for frame in frames])


def test_each_joint_has_a_unit_where_joints_differ(tmp_path):
    assert column_unit("position", [False, True]) == ["rad", "m"]
    assert column_unit("position", [False, False]) == column_unit("position") == "rad"
    assert column_unit("command_stiffness", [True, True]) == "N/m"
    assert column_unit("words") is None
    h5py = pytest.importorskip("h5py")
    with ExitStack() as files:
        sink = Hdf5Sink(tmp_path / "out.h5", {}, files, slides=[False, True])
        sink.append("frames", {"tick": np.arange(3), "position": np.zeros((3, 2))})
        sink.append("joints", {"joint": np.arange(2), "upper": np.ones(2)})
    with h5py.File(tmp_path / "out.h5") as file:
        assert list(file["frames/position"].attrs["units"]) == ["rad", "m"]
        assert list(file["joints/upper"].attrs["units"]) == ["rad", "m"]


def test_ticks_pressures_and_joints_are_exact(tables, frames):
    np.testing.assert_array_equal(numbers(tables["frames"]["tick"]), [frame.tick for frame in frames])
    pressures = numbers(tables["pressures"]["pressure_Pa"])
    np.testing.assert_array_equal(pressures, [frame.pressures for frame in frames])
    for name, part in JOINT_COLUMNS.items():
        np.testing.assert_array_equal(numbers(tables["frames"][name]), [part(frame) for frame in frames])


def test_taxels_have_their_ids_and_places(tables, player):
    skin = player.prepared.skin
    taxels = tables["taxels"]
    assert [int(number) for number in taxels["id"]] == [1000 + 3 * taxel for taxel in range(len(skin))]
    assert [int(number) for number in taxels["channel"]] == [(1000 + 3 * taxel) % 12 for taxel in range(len(skin))]
    places = np.concatenate([patch.taxels.positions for patch in skin.patches])
    np.testing.assert_array_equal(np.stack([numbers(taxels[f"{axis}_m"]) for axis in "xyz"], axis=1), places)
    assert list(taxels["link"]) == [skin.patches[number].link for number in skin.patch_of]


def test_all_contacts_and_events_are_written(tables, frames, player):
    regions = [(frame.tick, region) for frame in frames for region in frame.regions]
    assert regions
    contacts = tables["contacts"]
    np.testing.assert_array_equal(numbers(contacts["tick"]), [tick for tick, _ in regions])
    np.testing.assert_array_equal(numbers(contacts["force_N"]), [region.force for _, region in regions])
    np.testing.assert_array_equal(numbers(contacts["map_y_m"]), [region.map_point[1] for _, region in regions])
    assert list(contacts["link"]) == [region.link for _, region in regions]
    assert list(tables["events"]["words"]) == [event.words for event in player.events]
    assert len(player.events) > 2


def test_image_columns_contain_the_tactile_images(tables, frames, player):
    if "images" not in tables:
        assert "pressure_Pa" in tables["pressures"]  # CSV has none
        return
    image = TactileImage(player.prepared.map, width=24)
    found = np.asarray(tables["images"]["image_kPa"], dtype=np.float32).reshape(len(frames), *image.shape)
    np.testing.assert_array_equal(found, [image.render(frame.pressures) for frame in frames])


def test_whole_recording_has_one_episode_and_no_damage(tables, player):
    assert [int(number) for number in tables["episodes"]["frames"]] == [len(player)]
    assert list(tables["episodes"]["label"]) == [player.prepared.scene.name]
    assert len(tables["damage"]["kind"]) == 0
    facts = dict(zip(tables["recording"]["fact"], tables["recording"]["value"], strict=True))
    assert facts["complete"] == "yes"


@pytest.mark.parametrize(
    "to", ["csv", *(pytest.param(kind, marks=pytest.mark.long) for kind in READERS if kind != "csv")]
)
def test_damaged_recording_is_marked_and_split_at_missing_frames(damaged, tmp_path, to):
    player = export_recording(damaged, tmp_path / "out", to=to, options=ExportOptions(image_width=0))
    assert player.damage
    tables = READERS[to](tmp_path / "out")
    assert list(tables["damage"]["kind"]) == [one.kind.value for one in player.damage]
    assert any("frames missing" in words for words in tables["damage"]["words"])
    lengths = [int(number) for number in tables["episodes"]["frames"]]
    assert len(lengths) == 2
    assert sum(lengths) == len(player)
    assert "images" not in tables


def test_csv_columns_of_taxels_are_named_by_id(player, tmp_path):
    export_recording(player, tmp_path / "out", to="csv")
    head = (tmp_path / "out" / "pressures.csv").read_text().partition("\n")[0].split(",")
    assert head == ["tick", "time_s", *(f"pressure_Pa.{label}" for label in taxel_labels(player.prepared.skin))]
    assert "pressure_Pa.id_1003" in head

"""Every export format has a module; a failed export leaves no files and states the remedy."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from tactile_maps.cli.parser import EXPORT_FORMATS
from tactile_maps.core.errors import ExportError
from tactile_maps.export.export import FORMATS, ExportOptions, export_recording

HERE = [name for name in FORMATS if name != "rerun"]


class CancelledError(Exception):
    """Cancelled by the user."""


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("to", HERE)
def test_cancelled_export_leaves_no_file(player, tmp_path, to):
    def progress(_text, share):
        if share > 0.3:
            raise CancelledError

    with pytest.raises(CancelledError):
        export_recording(player, tmp_path / "out", to=to, progress=progress)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("to", HERE)
def test_existing_file_or_folder_is_kept(player, tmp_path, to):
    target = tmp_path / "out"
    target.write_text("precious")
    with pytest.raises(ExportError, match="already exists"):
        export_recording(player, target, to=to)
    assert target.read_text() == "precious"
    target.unlink()
    target.mkdir()
    with pytest.raises(ExportError, match="folder of this name"):
        export_recording(player, target, to=to, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.long
def test_file_is_replaced_on_request(player, tmp_path):
    target = tmp_path / "out.npz"
    target.write_text("old")
    export_recording(player, target, to="npz", overwrite=True)
    assert target.stat().st_size > 1000


def test_unknown_format_names_the_nearest(player, tmp_path):
    with pytest.raises(ExportError, match="Did you mean parquet"):
        export_recording(player, tmp_path / "out", to="parket")


def test_command_line_offers_all_formats():
    assert tuple(FORMATS) == EXPORT_FORMATS


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("to", "module", "package"),
    [
        ("parquet", "pyarrow", "pyarrow>="),
        ("hdf5", "h5py", "h5py>="),
        ("mp4", "av", "av>="),
        ("lerobot", "pyarrow.parquet", "pyarrow>="),
        ("rosbag2", "rosbags.rosbag2", "rosbags>="),
        ("rerun", "rerun", "rerun-sdk>="),
    ],
)
def test_missing_package_error_states_the_install_command(player, tmp_path, monkeypatch, to, module, package):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ExportError, match=rf"{sys.executable} -m pip install .*'{package}"):
        export_recording(player, tmp_path / "out", to=to)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("options", [{"image_width": -1}, {"image_width": 4000}, {"rate": 0.0}])
def test_image_sizes_out_of_range_are_rejected(options):
    with pytest.raises(ExportError):
        ExportOptions(**options)


def test_formats_of_missing_packages_state_their_installation_before_an_export(monkeypatch):
    assert FORMATS["npz"].install == FORMATS["parquet"].install == ""
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    missing = [form.name for form in FORMATS.values() if form.install and form.name != "rerun"]
    assert missing == ["parquet", "lerobot"]
    assert f"{sys.executable} -m pip install" in FORMATS["lerobot"].install


def test_range_of_a_recording_is_exported(player, tmp_path):
    start, end = 0.25 * player.duration, 0.75 * player.duration
    part = export_recording(player, tmp_path / "part.npz", to="npz", span=(start, end))
    first, last = player.tick_at(start), player.tick_at(end)
    assert 0 < first < last < player.frame(len(player) - 1).tick
    with np.load(tmp_path / "part.npz") as tables:
        times = tables["frames.time_s"]
        events = tables["events.time_s"]
        begins = dict(zip(tables["recording.fact"], tables["recording.value"], strict=True))["begins_s"]
    tick = player.prepared.scene.tick
    assert (times[0], times[-1]) == pytest.approx((first * tick, last * tick))
    assert float(begins) == times[0]
    inside = [one.tick for one in player.events if first <= one.tick <= last]
    assert len(inside) < len(player.events)
    assert [round(time / tick) for time in events] == inside
    assert len(part) == len(times)
    assert [path.name for path in tmp_path.iterdir()] == ["part.npz"]
    with pytest.raises(ExportError, match="invalid range"):
        export_recording(player, tmp_path / "none.npz", to="npz", span=(player.duration + 1, player.duration + 2))

"""One format a file; whatever goes wrong leaves nothing behind, and says what to do."""

from __future__ import annotations

import sys

import pytest

from tactile_maps.cli.parser import EXPORT_FORMATS
from tactile_maps.core.errors import ExportError
from tactile_maps.export.export import FORMATS, ExportOptions, export_recording

HERE = [name for name in FORMATS if name != "rerun"]


class CancelledError(Exception):
    """By a person."""


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("to", HERE)
def test_a_cancelled_export_leaves_nothing(player, tmp_path, to):
    def progress(_text, share):
        if share > 0.3:
            raise CancelledError

    with pytest.raises(CancelledError):
        export_recording(player, tmp_path / "out", to=to, progress=progress)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("to", HERE)
def test_an_existing_file_or_folder_stays(player, tmp_path, to):
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
def test_a_file_is_replaced_when_asked(player, tmp_path):
    target = tmp_path / "out.npz"
    target.write_text("old")
    export_recording(player, target, to="npz", overwrite=True)
    assert target.stat().st_size > 1000


def test_an_unknown_format_names_the_nearest(player, tmp_path):
    with pytest.raises(ExportError, match="Did you mean parquet"):
        export_recording(player, tmp_path / "out", to="parket")


def test_the_command_line_offers_all_formats():
    assert tuple(FORMATS) == EXPORT_FORMATS


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("to", "module", "extra"),
    [
        ("parquet", "pyarrow", "export"),
        ("hdf5", "h5py", "export"),
        ("mp4", "av", "export"),
        ("lerobot", "pyarrow.parquet", "export"),
        ("rosbag2", "rosbags.rosbag2", "export"),
        ("rerun", "rerun", "rerun"),
    ],
)
def test_a_missing_package_says_how_to_install_it(player, tmp_path, monkeypatch, to, module, extra):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ExportError, match=rf"pip install 'tactile-maps\[{extra}\]'"):
        export_recording(player, tmp_path / "out", to=to)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("options", [{"image_width": -1}, {"image_width": 4000}, {"rate": 0.0}])
def test_sizes_have_bounds(options):
    with pytest.raises(ExportError):
        ExportOptions(**options)

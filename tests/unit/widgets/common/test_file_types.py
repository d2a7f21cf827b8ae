"""As what a file is opened that is named on the command line."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_widgets.common.file_types import FileRole, role_of

ROBOT = "<robot name='r'><link name='a'/></robot>"
TAXELS = "<robot name='r'><link name='a'/><sensor name='t'><tactile/></sensor></robot>"


@pytest.mark.parametrize(
    ("name", "text", "role"),
    [
        ("demo.MCAP", "", FileRole.RECORDING),
        ("own.toml", "", FileRole.SCENE),
        ("part.stl", "", FileRole.ROBOT),
        ("arm.urdf", ROBOT, FileRole.ROBOT),
        ("pad.urdf", TAXELS, FileRole.SKIN),
        ("taxels.csv", "", FileRole.SKIN),
    ],
)
def test_a_file_is_what_it_holds(tmp_path, name, text, role):
    (tmp_path / name).write_text(text)
    assert role_of(str(tmp_path / name)) is role


def test_arrays_are_a_map_or_taxels_by_what_is_in_them(tmp_path):
    np.savez(tmp_path / "table.npz", positions=np.zeros((3, 3)))
    assert role_of(str(tmp_path / "table.npz")) is FileRole.SKIN
    (tmp_path / "broken.npz").write_bytes(b"nothing of that kind")
    assert role_of(str(tmp_path / "broken.npz")) is FileRole.MAP, "whose reader says what is wrong"


def test_what_cannot_be_opened_is_refused_by_name(tmp_path):
    with pytest.raises(TactileMapsError, match="there is no such file"):
        role_of(str(tmp_path / "nothing.mcap"))
    (tmp_path / "notes.pdf").write_text("")
    with pytest.raises(UsageError, match="cannot be opened"):
        role_of(str(tmp_path / "notes.pdf"))

"""Kinds of files: by suffix, by content where the suffix is shared, and without harm from hostile files."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from tactile_maps.cli.commands.inspect import describe
from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_maps.core.file_kinds import SOURCES, FileKind
from tactile_maps.core.files import files_read
from tactile_maps.skin.formats.icub import positions as icub_positions
from tactile_maps.skin.formats.identify import identify, kind_of
from tactile_maps.skin.open import SkinOptions, open_skin
from tactile_maps.skin.taxel_placement.placement import PlacementSpec
from tests.support.file_kinds import KINDS, write_every_kind
from tests.support.special_files import make_special_file

WITH_SKIN = (FileKind.ROBOT, FileKind.ROBOT_WITH_TAXELS, FileKind.MESH, FileKind.TAXELS, FileKind.SKIN, FileKind.MAP)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return write_every_kind(tmp_path_factory.mktemp("kinds"))


@pytest.mark.parametrize("name", KINDS)
def test_kind_follows_from_suffix_and_content(files, name):
    assert identify(files[name]) is KINDS[name]


def test_every_kind_and_suffix_is_covered():
    assert set(KINDS.values()) == set(FileKind)
    assert {Path(name).suffix for name, kind in KINDS.items() if kind is FileKind.MESH} == set(FileKind.MESH.suffixes)


@pytest.mark.sampled(9)
@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind not in SOURCES])
def test_inspect_describes_every_kind(files, name):
    known = {FileKind.ROBOT_WITH_TAXELS: "robot with taxels", FileKind.MESH: "robot"}
    kind = KINDS[name]
    assert describe(str(files[name]))["kind"] == known.get(kind, kind.value)


@pytest.mark.sampled(7)
@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind in WITH_SKIN and name != "positions"])
def test_library_opens_every_kind_with_a_skin(files, name):
    robot = str(files["robot.urdf"]) if KINDS[name] is FileKind.TAXELS else None
    links = ("hand",) if name.startswith("arm") else ()
    options = SkinOptions(PlacementSpec(taxels=60), robot=robot, links=links)
    assert len(open_skin(files[name], options)) > 0


def test_missing_and_unknown_files_are_rejected(tmp_path):
    with pytest.raises(TactileMapsError, match="there is no such file"):
        identify(tmp_path / "missing.mcap")
    (tmp_path / "notes.pdf").write_text("")
    with pytest.raises(UsageError, match=r"cannot be opened.*\.pdf.*\.gltf.*\.msh"):
        identify(tmp_path / "notes.pdf")
    with pytest.raises(UsageError, match="this is a folder, not a file.*Choose a file in it"):
        identify(tmp_path)


def test_unexpected_kind_is_rejected_with_remedy(files):
    for name in (name for name, kind in KINDS.items() if kind in SOURCES):
        for reads in (describe, open_skin):
            with pytest.raises(UsageError, match=f"a {KINDS[name].value} cannot be opened here.*File > Connect"):
                reads(str(files[name]))
    with pytest.raises(UsageError, match=r"a scene cannot be opened here.*Give one of: \.mcap"):
        identify(files["own.toml"], expected=(FileKind.RECORDING,))


HOSTILE = {
    "empty": b"",
    "noise": bytes(range(256)) * 40,
    "zip": b"PK\x05\x06" + b"\xff" * 18,
    "mcap": b"\x89MCAP0\r\n\x01" + struct.pack("<QI", 2**63, 2**32 - 1),
    "xml": b'<!DOCTYPE x [<!ENTITY a "b">]><robot>' + b"<a>" * 10_000,
    "lines": b"seed," * 100_000,
}


@pytest.mark.parametrize("content", HOSTILE)
@pytest.mark.parametrize("suffix", [".npz", ".urdf", ".csv", ".mcap", ".txt", ".json", ".toml"])
def test_hostile_content_gets_a_kind_of_the_suffix(tmp_path, suffix, content):
    path = tmp_path / f"file{suffix}"
    path.write_bytes(HOSTILE[content])
    assert suffix in identify(path).suffixes


def test_pipe_does_not_block(tmp_path):
    assert kind_of(make_special_file("pipe", tmp_path / "pipe.csv")) is FileKind.TAXELS


def test_name_without_known_suffix_has_no_kind():
    assert [kind_of(name) for name in ("arm", "unitree_g1", "own.docx")] == [None, None, None]


def test_positions_are_parsed_once_to_open_a_skin(files, monkeypatch):
    parsed = []
    read = icub_positions.read_position_rows
    monkeypatch.setattr(icub_positions, "read_position_rows", lambda path: parsed.append(path) or read(path))
    with files_read() as opened:
        open_skin(files["icub.txt"], SkinOptions(robot=str(files["robot.urdf"])))
        first = len(parsed)
        opens = opened.count(files["icub.txt"])
        with pytest.raises(TactileMapsError, match="rod"):  # iCub has no link of that name
            open_skin(files["icub.txt"])
    assert (first, len(parsed)) == (1, 2)
    assert opens == 2  # the first 4 kB to distinguish positions from tables, then the file

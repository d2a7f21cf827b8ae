"""The entry in the menu of a desktop: written, found again, removed; nothing half done."""

from __future__ import annotations

import json
import re
import shutil
import sys
from configparser import ConfigParser
from xml.etree import ElementTree

import pytest

from tactile_maps.cli.commands.desktop import desktop_entry, desktop_files, launcher
from tactile_widgets.__main__ import main

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="desktop entries are for Linux")


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """The user's own folder of data."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    return tmp_path


def parsed(text: str):
    parser = ConfigParser(interpolation=None)
    parser.optionxform = str
    parser.read_string(text)
    return parser["Desktop Entry"]


def test_entry_and_icon_are_written_and_removed(capsys):
    assert main(["desktop"]) == 0
    entry, icon, types = desktop_files()
    assert str(entry) in capsys.readouterr().out
    assert icon.read_bytes().startswith(b"<svg")
    names = "{http://www.freedesktop.org/standards/shared-mime-info}"
    stated = ElementTree.parse(types).getroot().findall(f"{names}mime-type")
    claimed = {kind.get("type"): kind.find(f"{names}glob").get("pattern") for kind in stated}
    assert set(claimed.values()) == {"*.mcap", "*.npz"}
    assert ElementTree.parse(types).getroot().find(f".//{names}match").get("value") == r"\x89MCAP0\r\n"
    output = parsed(entry.read_text(encoding="utf8"))
    assert (output["Icon"], output["StartupWMClass"]) == (icon.stem, entry.stem)
    assert output["Exec"].endswith(' "gui" %f')
    assert output["MimeType"].strip(";").split(";") == list(claimed)
    assert main(["desktop", "--remove", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["removed"]) == 3
    assert not types.exists()
    assert not entry.exists()
    assert not icon.exists()
    assert main(["desktop", "--remove"]) == 0
    assert "no entry" in capsys.readouterr().out


def test_arguments_with_special_characters_reach_the_command_unchanged():
    words = ('/home/a b/50% "new" $x`y/python', "-m", "tactile_maps")
    stated = parsed(desktop_entry(words))["Exec"].replace("\\\\", "\\").replace("%%", "%")
    quoted = re.findall(r'"((?:[^"\\]|\\.)*)"', stated)
    assert tuple(re.sub(r"\\(.)", r"\1", word) for word in quoted) == words
    assert launcher()[-1] == "gui"


@pytest.mark.skipif(shutil.which("update-mime-database") is None, reason="needs shared-mime-info's own tool")
def test_file_types_are_registered_immediately():
    assert main(["desktop"]) == 0
    *_, types = desktop_files()
    known = (types.parent.parent / "globs2").read_text()
    assert "application/x-mcap:*.mcap" in known
    assert b"\x89MCAP0\r\n" in (types.parent.parent / "magic").read_bytes()


def test_folder_that_cannot_be_created_is_named(home, capsys):
    (home / "share").write_text("a file, not a folder")
    assert main(["desktop"]) == 1
    assert "Set XDG_DATA_HOME" in capsys.readouterr().err

"""The guide command prints the location of its pages."""

from __future__ import annotations

import json

import pytest

from tactile_maps.cli.commands.guide import find_page, page_names
from tactile_maps.core.errors import UsageError
from tactile_widgets.__main__ import main


def test_every_page_is_listed_with_the_start_page_first():
    assert page_names()[0] == "index"
    assert {"maps", "touch", "control", "measurements"} <= set(page_names())
    assert all(find_page(name).read_text(encoding="utf8").startswith("# ") for name in page_names())


def test_unknown_pages_name_the_nearest():
    with pytest.raises(UsageError, match="unknown page.*mpas.*Did you mean maps"):
        find_page("mpas")
    assert main(["guide", "mpas"]) == 2


def test_path_is_printed_without_a_display(capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    assert main(["guide", "maps"]) == 0
    assert str(find_page("maps")) in capsys.readouterr().out


def test_page_is_described_as_json(capsys):
    assert main(["guide", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["file"] == str(find_page("index"))
    assert "maps" in found["pages"]

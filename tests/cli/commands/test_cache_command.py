"""What the command line says of the prepared scenes on disk."""

from __future__ import annotations

import json

from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_widgets.__main__ import main


def test_what_is_kept_is_shown_and_removed(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (tmp_path / "0123.prepared").write_bytes(b"0" * 1_500_000)
    assert main(["cache"]) == 0
    said = capsys.readouterr().out
    assert str(tmp_path) in said
    assert "1.5 MB of 500 MB" in said
    assert main(["cache", "--clear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"] == 1
    assert not list(tmp_path.iterdir())


def test_off_is_said(monkeypatch, capsys):
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    assert main(["cache"]) == 2
    assert "TACTILE_MAPS_CACHE" in capsys.readouterr().err

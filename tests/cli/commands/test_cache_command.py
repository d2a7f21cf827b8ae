"""Cache of prepared scenes on the command line."""

from __future__ import annotations

import json

from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_widgets.__main__ import main


def test_cache_is_listed_and_cleared(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (tmp_path / "0123.prepared").write_bytes(b"0" * 1_500_000)
    assert main(["cache"]) == 0
    output = capsys.readouterr().out
    assert str(tmp_path) in output
    assert "1.5 MB of 500 MB" in output
    assert main(["cache", "--clear", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"] == 1
    assert not list(tmp_path.iterdir())


def test_disabled_cache_is_reported(monkeypatch, capsys):
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    assert main(["cache"]) == 2
    assert "TACTILE_MAPS_CACHE" in capsys.readouterr().err

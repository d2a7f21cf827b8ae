"""Settings that the window stores."""

from __future__ import annotations

import gc
import inspect
import tempfile
from pathlib import Path

from tactile_widgets.common.settings import Settings
from tactile_widgets.window import application


def test_recent_files_are_the_last_eight_distinct_newest_first(tmp_path):
    settings = Settings(tmp_path / "window.ini")
    for number in range(10):
        settings.add_recent(f"{number}.toml")
    settings.add_recent("5.toml")
    assert settings.recent == [f"{number}.toml" for number in (5, 9, 8, 7, 6, 4, 3, 2)]


def test_temporary_settings_leave_no_file_and_replace_no_device(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    settings = Settings.temporary()
    (folder,) = tmp_path.iterdir()
    settings.theme = "light"
    assert settings.theme == "light"
    assert Path(settings._store.fileName()).parent == folder, "no device, which Qt would replace"
    del settings
    gc.collect()
    assert list(tmp_path.iterdir()) == []


def test_windows_for_pictures_store_no_settings_in_a_device():
    """Read, not tried: where it fails, a run as root would replace the machine's own null device."""
    assert "devnull" not in inspect.getsource(application)

"""What the window remembers."""

from __future__ import annotations

from widgets.common.settings import Settings


def test_recent_files_are_the_last_eight_newest_first_each_once(tmp_path):
    settings = Settings(tmp_path / "window.ini")
    for number in range(10):
        settings.add_recent(f"{number}.toml")
    settings.add_recent("5.toml")
    assert settings.recent == [f"{number}.toml" for number in (5, 9, 8, 7, 6, 4, 3, 2)]

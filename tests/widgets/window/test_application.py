"""Opening a window without a display gives a sentence with a remedy, never an abort."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication

from tactile_maps.core.errors import DisplayError
from tactile_maps.editing.document_file import save_document
from tactile_maps.scene.scene_file import scene_to_toml
from tactile_widgets.__main__ import main
from tactile_widgets.window.application import open_when_ready
from tactile_widgets.window.display import require_display
from tests.widgets.support.samples import coarse

ROOT = Path(__file__).resolve().parents[3]
NOBODY = ":4711"
linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="displays are named like this on Linux only")


@pytest.fixture
def on_screen(monkeypatch):
    """An environment without a platform or a display."""
    for name in ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


@linux
def test_missing_display_is_reported_with_a_remedy(on_screen):
    with pytest.raises(DisplayError, match=r"no display.*xvfb-run"):
        require_display()


@linux
@pytest.mark.parametrize("name", ["DISPLAY", "WAYLAND_DISPLAY"])
def test_unresponsive_display_is_named(on_screen, tmp_path, name):
    on_screen.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    on_screen.setenv(name, NOBODY)
    with pytest.raises(DisplayError, match=f"does not respond.*{name}={NOBODY}"):
        require_display()


def test_offscreen_platform_needs_no_display(on_screen):
    on_screen.setenv("QT_QPA_PLATFORM", "offscreen:size=800x600")
    require_display()


@linux
def test_program_reports_a_missing_display(on_screen, tmp_path):
    """Qt itself would end the process with a core dump; the error comes before the imports of the window."""
    environment = dict(os.environ) | {"DISPLAY": NOBODY, "XDG_CONFIG_HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-m", "tactile_maps", "gui"],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    assert "does not respond" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.qt_log_ignore("This plugin does not support")
def test_map_named_on_the_command_line_is_opened_after_its_scene(window_again, qtbot, tmp_path):
    save_document(window_again.editor.document, tmp_path / "mine.npz")
    open_when_ready(window_again, str(tmp_path / "mine.npz"))
    prepared = window_again.live.prepared
    window_again.live.show_prepared(prepared)
    qtbot.waitUntil(lambda: window_again.settings.recent[:1] == [str(tmp_path / "mine.npz")])
    assert window_again.presenters.map_files.path == tmp_path / "mine.npz"
    window_again.settings.add_recent("another")
    window_again.live.show_prepared(prepared)
    QApplication.processEvents()
    assert window_again.settings.recent[0] == "another", "once"


@pytest.mark.parametrize(
    ("words", "said", "code"),
    [
        (("nothing.mcap",), "no such file", 1),
        (("notes.pdf",), "cannot be opened", 2),
        (("own.toml", "--scene", "arm"), "named twice", 2),
    ],
)
def test_unsupported_file_is_rejected_before_the_window_opens(tmp_path, monkeypatch, capsys, words, said, code):
    for name in ("notes.pdf", "own.toml"):
        (tmp_path / name).write_text("")
    monkeypatch.chdir(tmp_path)
    assert main(["gui", *words]) == code
    assert said in capsys.readouterr().err


def test_scene_file_named_on_the_command_line_is_the_document(window_again, tmp_path, monkeypatch, scene_cache):
    window = window_again
    path = tmp_path / "copied.toml"
    path.write_text(scene_to_toml(coarse(150)))
    opened = window.presenters.files.open_given
    monkeypatch.setattr("tactile_widgets.window.application.launch", lambda scene, *, file: opened(scene, file))
    monkeypatch.setattr("tactile_widgets.window.display.require_display", lambda: None)
    main(["gui", "--scene", str(path)])
    assert window.windowTitle().startswith("copied.toml[*] – arm")
    assert str(path) in window.settings.recent
    window.action("copy_command").trigger()
    assert QGuiApplication.clipboard().text() == f"tactile-maps gui --scene {path}"

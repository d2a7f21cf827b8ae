"""The window where nothing can be stored: on a full disk, a read-only one, and without a home folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

ROOT = Path(__file__).resolve().parents[3]
WINDOW = """
import sys
from dataclasses import replace
from tactile_maps.editing.arrange import rotate
from tactile_maps.scene.scene_file import load_scene
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from tactile_widgets.window import application
from tactile_widgets.window.main_window import MainWindow
import json

def look():
    (window,) = [one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow)]
    live, editor, files = window.live, window.editor, window.presenters.map_files
    if live.shown is None or live.shown.time < 0.1 or not window.robot_view.display.actors.prepared:
        return
    timer.stop()
    window.robot_view.display.draw_now(quality=1.0)
    window.settings.theme = "light"
    editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    for _ in range(3):
        files.autosave()
        files._wait()
    live.show_prepared(live.prepared)
    texts = [item.text for item in messages]
    print(json.dumps({"messages": texts, "steps": editor.history.names, "time": live.shown.time}), flush=True)
    files.give_up()
    window.close()

if __name__ == "__main__":
    class Said:
        def __init__(self, text):
            self.text = text

    messages = []
    opened = MainWindow.__init__

    def listen(window, *arguments, **options):
        opened(window, *arguments, **options)
        window.notifier.message_shown.connect(lambda text, fault: messages.append(Said(text)) if fault else None)

    MainWindow.__init__ = listen
    application.make_application()
    timer = QTimer()
    timer.timeout.connect(look)
    timer.start(50)
    scene = load_scene("arm")
    application.launch(replace(scene, stimuli=(), cover=replace(scene.cover, taxels=60, thickness=0.01)))
"""
HOMES = {
    "full": "mount -t tmpfs -o size=64k tmpfs {home} && dd if=/dev/zero of={home}/fill bs=1k 2>/dev/null",
    "read-only": "mount -t tmpfs -o ro tmpfs {home}",
    "missing": "true",
}


@pytest.fixture
def mounting(tmp_path):
    """Skip where this system does not permit a mount, not even in a namespace of its own."""
    (tmp_path / "trial").mkdir()
    command = ["unshare", "-rm", "mount", "-t", "tmpfs", "tmpfs", str(tmp_path / "trial")]
    if shutil.which("unshare") is None or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("this system does not permit mounting (unshare -rm mount)")


def window_at(home, script, prepare):
    """Open the window with this home folder; what it prints, and everything on stderr."""
    folders = {name: str(home) for name in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME")}
    environment = dict(os.environ) | folders | {"QT_QPA_PLATFORM": "offscreen"}
    for name in ("TACTILE_MAPS_CACHE", "MESA_SHADER_CACHE_DISABLE", "MESA_SHADER_CACHE_DIR", "XDG_DATA_HOME"):
        environment.pop(name, None)
    line = f"{prepare}; exec {sys.executable} {script}"
    words = ["unshare", "-rm", "sh", "-c", line] if "mount" in prepare else ["sh", "-c", line]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    return json.loads(done.stdout), done.stderr


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="mounts a file system")
@pytest.mark.parametrize("kind", ["full", pytest.param("read-only", marks=pytest.mark.long)])
def test_window_opens_and_works_where_nothing_can_be_stored(mounting, tmp_path, kind):
    home = tmp_path / "home"
    script = tmp_path / "window.py"
    home.mkdir()
    script.write_text(WINDOW)
    said, errors = window_at(home, script, HOMES[kind].format(home=home))
    check(said, errors, {"full": "No space left on device", "read-only": "Read-only file system"}[kind])


@pytest.mark.long
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc cannot hold a folder on Linux only")
def test_window_opens_and_works_without_a_home_folder(tmp_path):
    script = tmp_path / "window.py"
    script.write_text(WINDOW)
    said, errors = window_at(Path("/proc/no-home"), script, HOMES["missing"])
    check(said, errors, "No such file or directory")


def check(said, errors, reason):
    """Require a single message about storage, a working editor, and no other output."""
    messages = [text for text in said["messages"] if "cannot be" in text]
    assert messages[0].startswith("Settings and copies of unsaved edits cannot be stored: " + reason), messages
    assert said["steps"][-1] == "Rotate"
    assert len(messages) == 1, "once, also where an autosave fails"
    noise = [line for line in errors.splitlines() if "propagateSizeHints" not in line]
    assert noise == []

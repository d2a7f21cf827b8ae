"""The app as a user starts it, on a separate X server, with mouse and keyboard input."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from textwrap import indent

ROOT = Path(__file__).resolve().parents[2]

# Start of every script: a window on a small arm, and a function that reports events to the test.
START = """
import json, sys
from dataclasses import replace
from pathlib import Path
from PySide6.QtCore import QPoint, QPointF, QTimer
from tactile_maps.scene.scene_file import load_scene
from tactile_widgets.window import application
from tactile_widgets.common.colours import THEMES
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.window.main_window import MainWindow
from tactile_widgets.common.settings import Settings

FOLDER = Path(sys.argv[1])

def write(name, value):
    path = FOLDER / name
    path.with_suffix(".tmp").write_text(json.dumps(value))
    path.with_suffix(".tmp").rename(path)

def open_window():
    application.make_application()
    window = MainWindow(Settings(FOLDER / "window.ini"))
    window.set_theme("dark")
    window.resize(1280, 800)
    window.move(0, 0)
    window.show()
    return window

def live(window, ready):
    # A second and a half after its map is there, the layout is final.
    window.live.prepared_changed.connect(lambda _prepared: QTimer.singleShot(1500, ready))
    scene = load_scene("arm")
    window.live.open_scene(replace(scene, stimuli=(), cover=replace(scene.cover, taxels=300)))
    application.make_application().exec()
"""


class RealApp:
    """App in its own process. Mutable; ``close`` ends it.

    Args:
        screen: X display.
        folder: Folder for files that the app writes.
        script: Script that runs after ``START``.
    """

    def __init__(self, screen: str, folder: Path, script: str) -> None:
        self.folder = folder
        # Child processes import the started file and must not open windows.
        guarded = "if __name__ == '__main__':\n" + indent(script, "    ")
        (folder / "window.py").write_text(START + guarded)
        self._log = (folder / "log.txt").open("w")
        self._environment = {k: v for k, v in os.environ.items() if k not in ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY")}
        self._environment |= {"DISPLAY": screen, "XDG_STATE_HOME": str(folder / "state")}
        self.process = subprocess.Popen(
            [sys.executable, folder / "window.py", folder], env=self._environment, stdout=self._log, stderr=self._log
        )

    def hand(self, *words: object) -> None:
        """Run an xdotool command."""
        subprocess.run(["xdotool", *map(str, words)], env=self._environment, check=True)

    def wait_for(self, condition, seconds: float = 180.0) -> None:
        """Wait until the condition holds. Fail when the app ends or at a deadline for busy machines."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if condition():
                return
            try:
                code = self.process.wait(timeout=0.1)
            except subprocess.TimeoutExpired:
                continue
            raise AssertionError(f"the app ended with {code}: {(self.folder / 'log.txt').read_text()}")
        raise AssertionError("waited in vain")

    def read(self, name: str):
        """Return the value that the app last wrote under a name, or None."""
        path = self.folder / name
        return json.loads(path.read_text()) if path.exists() else None

    def close(self) -> None:
        """Close the app."""
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()
        self._log.close()

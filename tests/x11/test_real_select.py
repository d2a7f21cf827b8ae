"""A lasso with a real mouse on a real X server: drawn on the map, told by the app as a user starts it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from widgets.select_hand import inside

ROOT = Path(__file__).resolve().parents[2]
MISSING = [tool for tool in ("Xvfb", "xdotool") if shutil.which(tool) is None]

pytestmark = [
    pytest.mark.x11,
    pytest.mark.skipif(bool(MISSING), reason=f"needs {', '.join(MISSING)} (apt-get install xvfb xdotool)"),
]

# The window tells where its taxels are on the screen, and after that what is selected, whenever it changes.
HELPER = """
import json, sys
from dataclasses import replace
from pathlib import Path
from PySide6.QtCore import QPoint, QTimer
from app.simulation.scene_file import load_scene
from widgets import launch
from widgets.colours import THEMES, apply_theme
from widgets.main_window import MainWindow
from widgets.settings import Settings

def write(path, value):
    path.with_suffix(".tmp").write_text(json.dumps(value))
    path.with_suffix(".tmp").rename(path)

def main():
    folder = Path(sys.argv[1])
    app = launch.make_application()
    apply_theme(app, THEMES["dark"])
    window = MainWindow(Settings(folder / "window.ini"))
    window.resize(1280, 800)
    window.move(0, 0)
    window.show()
    poked = []
    window.views.poke_pressed.connect(poked.append)

    def tell(_prepared):
        QTimer.singleShot(1500, write_places)

    def write_places():
        window.activateWindow()  # there is no window manager that would
        corner = window.map_view.viewport().mapToGlobal(QPoint(0, 0))
        places = window.map_view.taxel_pixels() + [corner.x(), corner.y()]
        first = window.live.prepared.skin.first.tolist()
        write(folder / "places.json", {"taxels": places.tolist(), "first": first})

    def write_selected():
        selected = window.views.selection.taxels.tolist()
        write(folder / "selected.json", {"taxels": selected, "pokes": len(poked), "tool": window.views.tool.value})

    def write_corners():
        outline = window.map_view.chooser.rubber.outline
        write(folder / "corners.json", 0 if outline is None else len(outline))

    window.views.selection.changed.connect(write_selected)
    window.map_view.chooser.drawn.connect(write_corners)
    window.live.prepared_changed.connect(tell)
    scene = load_scene("arm")
    window.live.open_scene(replace(scene, strokes=(), cover=replace(scene.cover, taxels=300)))
    app.exec()

if __name__ == "__main__":
    main()
"""


@pytest.fixture
def screen():
    """An X server of our own; its number is told by itself."""
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
        pass_fds=(writing,),
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as told:
        number = told.readline().strip()
    assert number, "Xvfb did not start"
    yield f":{number}"
    server.terminate()
    server.wait()


class App:
    """The app in its own process, and a hand on mouse and keys."""

    def __init__(self, screen, folder):
        script = folder / "window.py"
        script.write_text(HELPER)
        self.folder = folder
        self.log = (folder / "log.txt").open("w")
        self.environment = {k: v for k, v in os.environ.items() if k not in ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY")}
        self.environment |= {"DISPLAY": screen, "PYTHONPATH": str(ROOT)}
        self.process = subprocess.Popen(
            [sys.executable, script, folder], env=self.environment, stdout=self.log, stderr=self.log
        )

    def hand(self, *words):
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True)

    def wait_for(self, condition, seconds=60.0):
        """Look again and again, between two looks waiting for nothing but the app's end, which is a failure."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if condition():
                return
            try:
                code = self.process.wait(timeout=0.1)
            except subprocess.TimeoutExpired:
                continue
            raise AssertionError(f"the app ended with {code}")
        raise AssertionError("waited in vain")

    def read(self, name):
        path = self.folder / name
        return json.loads(path.read_text()) if path.exists() else None

    def selected(self):
        told = self.read("selected.json")
        return [] if told is None else told["taxels"]

    def close(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()
        self.log.close()


@pytest.fixture
def app(screen, tmp_path):
    app = App(screen, tmp_path)
    yield app
    app.close()


def test_a_lasso_on_the_map_selects_what_it_encloses_and_escape_lets_go(app):
    app.wait_for(lambda: app.read("places.json"))
    told = app.read("places.json")
    taxels = np.array(told["taxels"])
    own = taxels[told["first"][0] : told["first"][1]]
    middle = np.median(own, axis=0).round()
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    path = (middle + 45 * np.stack([np.cos(turn), np.sin(turn)], axis=1)).round()
    # A real pixel's middle is not where a taxel's own number ends: within one of the line either is right.
    sure, wanted = (np.flatnonzero(inside(middle + k * (path - middle), taxels)).tolist() for k in (0.96, 1.04))
    assert len(sure) >= 3

    app.hand("mousemove", *middle.astype(int), "click", 2)  # the middle button gives the view the focus, and no poke
    app.hand("key", "l")
    app.hand("mousemove", *path[0].astype(int), "mousedown", 1)
    for number, place in enumerate(path[1:].astype(int), start=2):
        app.hand("mousemove", *place)
        app.wait_for(lambda number=number: app.read("corners.json") == number)  # Qt would skip some of a hasty hand's
    app.wait_for(lambda: set(sure) <= set(app.selected()))
    app.hand("mouseup", 1)
    chosen = app.read("selected.json")
    assert chosen["tool"] == "select_lasso"
    assert chosen["pokes"] == 0
    assert set(chosen["taxels"]) <= set(wanted)

    app.hand("keydown", "shift", "mousemove", *own[0].round().astype(int), "click", 1, "keyup", "shift")
    both = sorted({*chosen["taxels"], 0} if 0 not in chosen["taxels"] else {*chosen["taxels"]} - {0})
    app.wait_for(lambda: app.selected() == both)
    app.hand("key", "Escape")
    app.wait_for(lambda: app.selected() == [])

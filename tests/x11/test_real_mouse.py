"""A real mouse on a real X server: the app as a user starts it, poked with xdotool, answers in its recording."""

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

from app.errors import RecordingError
from app.recording.player import Player
from app.simulation.poke import PokePressed, PokeReleased

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ("Xvfb", "xdotool")
MISSING = [tool for tool in TOOLS if shutil.which(tool) is None]

pytestmark = [
    pytest.mark.x11,
    pytest.mark.skipif(bool(MISSING), reason=f"needs {', '.join(MISSING)} (apt-get install xvfb xdotool)"),
]

# The window writes the pixels of a visible taxel in both views to a file, so that the mouse knows where to go.
HELPER = """
import json, sys
import numpy as np
from pathlib import Path
from PySide6.QtCore import QPointF, QTimer
from app.simulation.scene_file import load_scene
from dataclasses import replace
from widgets import launch
from widgets.colours import THEMES, apply_theme
from widgets.main_window import MainWindow
from widgets.settings import Settings

def main():
    folder = Path(sys.argv[1])
    app = launch.make_application()
    apply_theme(app, THEMES["dark"])
    window = MainWindow(Settings(folder / "window.ini"))
    window.resize(1280, 800)
    window.move(0, 0)
    window.show()

    def tell(_prepared):
        QTimer.singleShot(1500, write)

    def write():
        view, skin = window.robot_view, window.live.prepared.skin
        for taxel in range(len(skin)):
            at = skin.taxel_point(taxel)
            pixel = view.pixel_of(at).toPoint()
            near = [view._at(QPointF(pixel.x() + x, pixel.y() + y)) for x in (-4, 4) for y in (-4, 4)]
            # A taxel that faces the eye: four pixels aside is a centimetre aside, not more.
            if all(hit and np.linalg.norm(skin.position(hit) - skin.position(at)) < 0.02 for hit in near):
                break
        body = view.mapToGlobal(pixel)
        flat = window.map_view.viewport().mapToGlobal(window.map_view.pixel_of(at).toPoint())
        window.live.start_recording(folder / "poked.mcap")
        places = {"taxel": taxel, "body": [body.x(), body.y()], "map": [flat.x(), flat.y()]}
        (folder / "places.tmp").write_text(json.dumps(places))
        (folder / "places.tmp").rename(folder / "places.json")

    window.live.prepared_changed.connect(tell)
    scene = load_scene("arm")
    window.live.open_scene(replace(scene, strokes=(), cover=replace(scene.cover, taxels=300)))
    app.exec()

if __name__ == "__main__":
    main()
"""


def wait_for(app: subprocess.Popen, condition, seconds: float = 60.0) -> None:
    """Look again and again, between two looks waiting for nothing but the app's end, which is a failure."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return
        try:
            code = app.wait(timeout=0.1)
        except subprocess.TimeoutExpired:
            continue
        raise AssertionError(f"the app ended with {code}")
    raise AssertionError("waited in vain")


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


def test_a_poke_on_the_mesh_and_on_the_map_is_felt_at_the_same_place(screen, tmp_path):
    script = tmp_path / "window.py"
    script.write_text(HELPER)
    environment = {key: value for key, value in os.environ.items() if key not in ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY")}
    environment |= {"DISPLAY": screen, "PYTHONPATH": str(ROOT)}
    log = (tmp_path / "log.txt").open("w")
    app = subprocess.Popen([sys.executable, script, tmp_path], env=environment, stdout=log, stderr=log)

    def mouse(*words):
        subprocess.run(["xdotool", *map(str, words)], env=environment, check=True)

    try:
        wait_for(app, (tmp_path / "places.json").exists)
        places = json.loads((tmp_path / "places.json").read_text())
        recording = tmp_path / "poked.mcap"
        for number, where in enumerate(("body", "map"), start=1):
            mouse("mousemove", *places[where], "mousedown", 1)
            wait_for(app, lambda number=number: len(_presses(recording)) == number)
            held = _written(recording)[0]
            wait_for(app, lambda held=held: _written(recording)[0] > held + 100)
            mouse("mouseup", 1)
            wait_for(app, lambda number=number: len(_releases(recording)) == number)
    finally:
        app.send_signal(signal.SIGTERM)
        app.wait()
        log.close()
    player = Player(recording)
    (body, flat), skin = _presses(recording), player.prepared.skin
    assert body.at.patch == flat.at.patch
    wanted = skin.position(skin.taxel_point(places["taxel"]))
    # A pixel is a good two millimetres in either view of this small window.
    assert np.linalg.norm(skin.position(body.at) - wanted) < 5e-3
    assert np.linalg.norm(skin.position(flat.at) - wanted) < 5e-3
    strongest = max(region.force for n in range(len(player)) for region in player.frame(n).regions)
    assert strongest > 1.0


def _written(path: Path) -> tuple[int, list]:
    """Frames and inputs in the file so far; none while its first chunk is not complete."""
    try:
        player = Player(path)
    except RecordingError:
        return 0, []
    return len(player), [act for _, act in player.inputs]


def _presses(path: Path) -> list[PokePressed]:
    return [act for act in _written(path)[1] if isinstance(act, PokePressed)]


def _releases(path: Path) -> list[PokeReleased]:
    return [act for act in _written(path)[1] if isinstance(act, PokeReleased)]

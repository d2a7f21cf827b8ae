"""Poking with a real mouse on an X server: the app as a user starts it records the contact."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.tactile.poke import PokePressed, PokeReleased

# The window writes the pixels of a visible taxel in both views to a file, for the mouse.
SCRIPT = """
import numpy as np

window = open_window()

def ready():
    window.live.recording.start(FOLDER / "poked.mcap")
    QTimer.singleShot(500, locate)  # the row of the timeline makes the views lower

def locate():
    view, skin = window.robot_view, window.live.prepared.skin
    for taxel in range(len(skin)):
        at = skin.taxel_point(taxel)
        pixel = view.pixel_of(at).toPoint()
        near = [view.point_at(QPointF(pixel.x() + x, pixel.y() + y)) for x in (-4, 4) for y in (-4, 4)]
        # A taxel that faces the eye: four pixels aside is a centimetre aside, not more.
        if all(hit and np.linalg.norm(skin.position(hit) - skin.position(at)) < 0.02 for hit in near):
            break
    body = view.mapToGlobal(pixel)
    flat = window.map_view.viewport().mapToGlobal(window.map_view.pixel_of(at).toPoint())
    write("places.json", {"taxel": taxel, "body": [body.x(), body.y()], "map": [flat.x(), flat.y()]})

live(window, ready)
"""


def test_poke_on_mesh_and_on_map_is_measured_at_the_same_place(app):
    app.wait_for(lambda: app.read("places.json"))
    places = app.read("places.json")
    recording = app.folder / "poked.mcap"
    for number, where in enumerate(("body", "map"), start=1):
        app.hand("mousemove", *places[where], "mousedown", 1)
        app.wait_for(lambda number=number: len(_presses(recording)) == number)
        held = _written(recording)[0]
        app.wait_for(lambda held=held: _written(recording)[0] > held + 100)
        app.hand("mouseup", 1)
        app.wait_for(lambda number=number: len(_releases(recording)) == number)
    app.close()
    player = RecordingPlayer(recording)
    (body, flat), skin = _presses(recording), player.prepared.skin
    assert body.at.patch == flat.at.patch
    expected = skin.position(skin.taxel_point(places["taxel"]))
    # A pixel is about two millimetres in both views of this small window.
    assert np.linalg.norm(skin.position(body.at) - expected) < 5e-3
    assert np.linalg.norm(skin.position(flat.at) - expected) < 5e-3
    strongest = max(region.force for n in range(len(player)) for region in player.frame(n).regions)
    assert strongest > 1.0


def _written(path: Path) -> tuple[int, list]:
    """Return the frames and inputs in the file so far; none until its first chunk is complete."""
    try:
        player = RecordingPlayer(path)
    except RecordingError:
        return 0, []
    return len(player), [act for _, act in player.inputs]


def _presses(path: Path) -> list[PokePressed]:
    return [act for act in _written(path)[1] if isinstance(act, PokePressed)]


def _releases(path: Path) -> list[PokeReleased]:
    return [act for act in _written(path)[1] if isinstance(act, PokeReleased)]

"""Editing with a real mouse on an X server: moving a patch, dragging a pin and drawing a seam change the saved map."""

from __future__ import annotations

import itertools

import numpy as np

from tactile_maps.editing.document_file import load_document

# The window reports where taxels are on the screen, and the name of each step with the saved document.
SCRIPT = """
from tactile_maps.editing.document_file import save_document

window = open_window()

def ready():
    window.activateWindow()  # there is no window manager that would
    window.hint_bar.hide()
    corner = window.map_view.viewport().mapToGlobal(QPoint(0, 0))
    places = window.map_view.taxel_pixels() + [corner.x(), corner.y()]
    save_document(window.editor.document, FOLDER / "first.npz")
    write("places.json", {"taxels": places.tolist(), "first": window.live.prepared.skin.first.tolist()})

def settled(document, name):
    save_document(document, FOLDER / "now.npz")
    write("steps.json", {"names": window.editor.history.names, "busy": window.editor.busy, "last": name})

def report_tool():
    write("tool.json", window.views.tool.name)

def rested():
    write("rested.json", True)

window.editor.settled.connect(settled)
window.editor.rested.connect(rested)
window.editor.failed.connect(lambda text: write("failed.json", text))
for name in ("arrange", "pins", "seams"):
    window.action(name).triggered.connect(report_tool)
live(window, ready)
"""


def steps(app):
    """Return the names of the steps so far, without the first."""
    output = app.read("steps.json")
    return [] if output is None else output["names"][1:]


def drag(app, start, *path):
    """Press, move in small steps as a hand does, and release."""
    app.hand("mousemove", *np.round(start).astype(int), "mousedown", 1)
    here = np.asarray(start, float)
    for goal in path:
        for share in np.linspace(0, 1, 8)[1:]:
            app.hand("mousemove", *np.round(here + share * (np.asarray(goal) - here)).astype(int), "sleep", 0.02)
        here = np.asarray(goal, float)
    app.hand("mouseup", 1)


def take(app, key, tool):
    app.hand("key", key)
    app.wait_for(lambda: app.read("tool.json") == tool)


def test_patch_is_moved_a_pin_dragged_and_a_seam_drawn(app):
    app.wait_for(lambda: app.read("places.json"))
    output = app.read("places.json")
    taxels = np.array(output["taxels"])
    first = output["first"]
    patches = [taxels[a:b] for a, b in itertools.pairwise(first)]
    before = load_document(app.folder / "first.npz")
    middles = [patch[np.linalg.norm(patch - patch.mean(axis=0), axis=1).argmin()] for patch in patches]

    # The middle button gives the view the focus without a poke.
    app.hand("mousemove", *np.round(middles[0]).astype(int), "click", 2)
    take(app, "v", "arrange")
    drag(app, middles[2], middles[2] + [60, 25])
    app.wait_for(lambda: steps(app) == ["Move"])
    moved = load_document(app.folder / "now.npz")
    by = np.subtract(moved.layout.placements[2].offset, before.layout.placements[2].offset)
    assert by[0] > 0.05
    assert by[1] < -0.02
    assert moved.layout.placements[:2] == before.layout.placements[:2]

    take(app, "n", "pins")
    drag(app, middles[0], middles[0] + [-25, -30])
    # The pin exists after its release, but a seam can be drawn only after the job has solved the patch.
    app.wait_for(lambda: steps(app)[1:] and app.read("rested.json"), 90)
    pinned = load_document(app.folder / "now.npz")
    assert len(pinned.patches[0].pins) == 1
    assert not np.array_equal(pinned.charts[0].plane, moved.charts[0].plane)

    take(app, "k", "seams")
    drag(app, middles[1], middles[1] + [4, -30])
    app.wait_for(lambda: len(steps(app)) == 3, 90)
    assert app.read("failed.json") is None
    seamed = load_document(app.folder / "now.npz")
    assert len(seamed.patches[1].seams.drawn) >= 2
    assert len(seamed.charts[1].plane) > len(pinned.charts[1].plane), "the skin is cut open there"

    app.hand("key", "--clearmodifiers", "ctrl+z", "ctrl+z", "ctrl+z")
    app.wait_for(lambda: app.read("steps.json")["last"] == "Undo: Move")
    assert load_document(app.folder / "now.npz").layout == before.layout

"""A lasso with a real mouse on an X server: drawing it on the map selects taxels in the app as a user starts it."""

from __future__ import annotations

import numpy as np

from tactile_widgets.views.interaction.polyline import points_in_polygon

# The window reports where its taxels are on the screen, and then each change of the selection.
SCRIPT = """
window = open_window()
poked = []
for gestures in window.views.interactions:
    gestures.poke_pressed.connect(poked.append)

def ready():
    window.activateWindow()  # there is no window manager that would
    corner = window.map_view.viewport().mapToGlobal(QPoint(0, 0))
    places = window.map_view.taxel_pixels() + [corner.x(), corner.y()]
    write("places.json", {"taxels": places.tolist(), "first": window.live.prepared.skin.first.tolist()})

def write_selected():
    selected = window.views.selection.taxels.tolist()
    write("selected.json", {"taxels": selected, "pokes": len(poked), "tool": window.views.tool.name})

def write_corners():
    outline = window.map_view.interaction.taxel_selector.rubber_band.outline
    write("corners.json", 0 if outline is None else len(outline))

window.views.selection.changed.connect(write_selected)
window.map_view.interaction.taxel_selector.drawn.connect(write_corners)
live(window, ready)
"""


def selected(app):
    """Return the numbers of the selected taxels."""
    output = app.read("selected.json")
    return [] if output is None else output["taxels"]


def test_lasso_on_the_map_selects_enclosed_taxels_and_escape_clears(app):
    app.wait_for(lambda: app.read("places.json"))
    output = app.read("places.json")
    taxels = np.array(output["taxels"])
    own = taxels[output["first"][0] : output["first"][1]]
    middle = np.median(own, axis=0).round()
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    path = (middle + 45 * np.stack([np.cos(turn), np.sin(turn)], axis=1)).round()
    # Pixels are not exact: a taxel within one pixel of the line may be selected or not.
    sure, expected = (
        np.flatnonzero(points_in_polygon(middle + k * (path - middle), taxels)).tolist() for k in (0.96, 1.04)
    )
    assert len(sure) >= 3

    app.hand("mousemove", *middle.astype(int), "click", 2)  # the middle button gives the view the focus without a poke
    app.hand("key", "l")
    app.hand("mousemove", *path[0].astype(int), "mousedown", 1)
    for number, place in enumerate(path[1:].astype(int), start=2):
        app.hand("mousemove", *place)
        app.wait_for(lambda number=number: app.read("corners.json") == number)  # Qt would merge faster moves
    app.wait_for(lambda: set(sure) <= set(selected(app)))
    app.hand("mouseup", 1)
    chosen = app.read("selected.json")
    assert chosen["tool"] == "select_lasso"
    assert chosen["pokes"] == 0
    assert set(chosen["taxels"]) <= set(expected)

    app.hand("keydown", "shift", "mousemove", *own[0].round().astype(int), "click", 1, "keyup", "shift")
    both = sorted({*chosen["taxels"], 0} if 0 not in chosen["taxels"] else {*chosen["taxels"]} - {0})
    app.wait_for(lambda: selected(app) == both)
    app.hand("key", "Escape")
    app.wait_for(lambda: selected(app) == [])

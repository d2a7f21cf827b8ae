"""A lasso with a real mouse on a real X server: drawn on the map, told by the app as a user starts it."""

from __future__ import annotations

import numpy as np

from tactile_widgets.views.interaction.polyline import points_in_polygon

# The window tells where its taxels are on the screen, and after that what is selected, whenever it changes.
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
    """The numbers of the selected taxels."""
    told = app.read("selected.json")
    return [] if told is None else told["taxels"]


def test_a_lasso_on_the_map_selects_what_it_encloses_and_escape_lets_go(app):
    app.wait_for(lambda: app.read("places.json"))
    told = app.read("places.json")
    taxels = np.array(told["taxels"])
    own = taxels[told["first"][0] : told["first"][1]]
    middle = np.median(own, axis=0).round()
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    path = (middle + 45 * np.stack([np.cos(turn), np.sin(turn)], axis=1)).round()
    # A real pixel's middle is not where a taxel's own number ends: within one of the line either is right.
    sure, wanted = (
        np.flatnonzero(points_in_polygon(middle + k * (path - middle), taxels)).tolist() for k in (0.96, 1.04)
    )
    assert len(sure) >= 3

    app.hand("mousemove", *middle.astype(int), "click", 2)  # the middle button gives the view the focus, and no poke
    app.hand("key", "l")
    app.hand("mousemove", *path[0].astype(int), "mousedown", 1)
    for number, place in enumerate(path[1:].astype(int), start=2):
        app.hand("mousemove", *place)
        app.wait_for(lambda number=number: app.read("corners.json") == number)  # Qt would skip some of a hasty hand's
    app.wait_for(lambda: set(sure) <= set(selected(app)))
    app.hand("mouseup", 1)
    chosen = app.read("selected.json")
    assert chosen["tool"] == "select_lasso"
    assert chosen["pokes"] == 0
    assert set(chosen["taxels"]) <= set(wanted)

    app.hand("keydown", "shift", "mousemove", *own[0].round().astype(int), "click", 1, "keyup", "shift")
    both = sorted({*chosen["taxels"], 0} if 0 not in chosen["taxels"] else {*chosen["taxels"]} - {0})
    app.wait_for(lambda: selected(app) == both)
    app.hand("key", "Escape")
    app.wait_for(lambda: selected(app) == [])

"""Timeline and curves of a recording with a real mouse on an X server: range, click, zoom, menu."""

from __future__ import annotations

import pytest

# The window records two seconds, replays them, and reports where times are on the screen and the effect of each action.
SCRIPT = """
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar

window = open_window()
bar, plots = window.timeline.findChild(ScrubBar), window.recording_plots

def places(widget, height):
    return {str(t): widget.mapToGlobal(QPoint(round(widget.x_of(t)), height)).toTuple() for t in (0.5, 1.0, 1.5)}

def write_state(_change=None):
    span, menu = window.timeline.range, window.presenters.notes.menu
    write("state.json", {
        "range": None if span is None else [span.start, span.end],
        "time": window.timeline.playhead.time,
        "view": plots.view.length,
        "marks": len(window.context.notes.value.marks),
        "menu": menu is not None and menu.isVisible(),
    })

def replay():
    recorder = window.live.recording.recorder
    if recorder.seconds >= 2.0:  # simulated time: a busy machine simulates less of it
        recording.stop()
        window.live.recording.stop()
        window.live.open_recording(FOLDER / "one.mcap")

def settle():
    if window.live.replay.player is not None and len(plots.times):
        settling.stop()
        QTimer.singleShot(500, finish)  # the layout may still change with the curves

def finish():
    window.activateWindow()  # there is no window manager that would
    write_state()
    write("places.json", {"bar": places(bar, 20), "plots": places(plots, 40)})

def ready():
    window.live.recording.start(FOLDER / "one.mcap")
    recording.start(50)
    settling.start(50)

recording, settling = QTimer(), QTimer()
recording.timeout.connect(replay)
settling.timeout.connect(settle)
watch = QTimer()
watch.timeout.connect(write_state)
watch.start(100)
live(window, ready)
"""


def test_drag_on_timeline_or_curves_selects_a_range_and_click_seeks(app):
    app.wait_for(lambda: app.read("places.json"))
    bar = app.read("places.json")["bar"]
    plots = app.read("places.json")["plots"]

    def drag(places, *, shift):
        app.hand(*(["keydown", "shift"] if shift else []), "mousemove", *places["0.5"], "mousedown", 1)
        app.hand("mousemove", *places["1.0"])
        app.hand("mousemove", *places["1.5"], "mouseup", 1, *(["keyup", "shift"] if shift else []))

    drag(bar, shift=True)
    app.wait_for(lambda: app.read("state.json")["range"] == pytest.approx([0.5, 1.5], abs=0.02))
    app.hand("mousemove", *plots["1.0"], "click", 1)
    app.wait_for(lambda: app.read("state.json")["time"] == pytest.approx(1.0, abs=0.02))
    whole = app.read("state.json")["view"]
    app.hand("click", 4, "click", 4)
    app.wait_for(lambda: app.read("state.json")["view"] == pytest.approx(whole / 1.25**2, rel=0.01))
    app.hand("click", "--repeat", 2, "--delay", 50, 1)
    app.wait_for(lambda: app.read("state.json")["view"] == pytest.approx(whole))
    app.hand("key", "ctrl+b")
    app.wait_for(lambda: app.read("state.json")["marks"] == 1)
    app.hand("mousemove", *bar["1.5"], "click", 3)
    app.wait_for(lambda: app.read("state.json")["menu"])

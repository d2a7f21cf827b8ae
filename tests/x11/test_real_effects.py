"""Switching an effect with a real mouse on an X server, in the app as a user starts it."""

from __future__ import annotations

# The window reports the positions of the box for friction and of its entry "on", and the simulated effects.
SCRIPT = """
window = open_window()
panel = window.column["effects"]

def place_of(widget, at):
    corner = widget.mapToGlobal(at)
    return [corner.x(), corner.y()]

def ready():
    window.activateWindow()  # there is no window manager that would
    window.action("effects").trigger()
    QTimer.singleShot(500, write_box)

def write_box():
    box = panel.lines["friction"].box
    write("box.json", place_of(box, box.rect().center()))

def write_state():
    view = panel.lines["friction"].box.view() if panel.lines else None
    if view is not None and view.isVisible():
        rows = {view.model().index(k, 0).data(): view.visualRect(view.model().index(k, 0)) for k in range(3)}
        write("list.json", place_of(view.viewport(), rows["on"].center()))
    if window.live.runner is not None:
        session = window.live.runner.session
        write("session.json", {"friction": session.effects.friction, "tick": session.frame.tick,
                               "says": panel.lines["friction"].words[1]})

timer = QTimer(window)
timer.timeout.connect(write_state)
timer.start(100)
live(window, ready)
"""


def session(app):
    return app.read("session.json")


def test_friction_is_switched_on_in_a_running_session(app):
    app.wait_for(lambda: app.read("box.json"))
    before = session(app)
    assert before["says"] == "off"
    assert not before["friction"]
    app.hand("mousemove", *app.read("box.json"), "click", 1)
    app.wait_for(lambda: app.read("list.json"))
    app.hand("mousemove", *app.read("list.json"), "click", 1)
    app.wait_for(lambda: session(app)["friction"])
    app.wait_for(lambda: session(app)["says"] == "on")
    after = session(app)
    assert after["tick"] > before["tick"], "time advanced"

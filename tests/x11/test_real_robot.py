"""The robot view with a real mouse on an X server: rotation, a finger left in place, menu, a dragged link."""

from __future__ import annotations

import numpy as np

# The window reports where skin and hand are on the screen, and the effect of each action.
SCRIPT = """
import numpy as np

window = open_window()
view, output = window.robot_view, {}

def report(name, value):
    if output.get(name) != value:
        output[name] = value
        write(name + ".json", value)

def on_screen(pixel):
    place = view.mapToGlobal(pixel)
    return [place.x(), place.y()]

def skin_pixel():
    skin = window.live.prepared.skin
    for taxel in range(len(skin)):
        pixel = view.pixel_of(skin.taxel_point(taxel)).toPoint()
        if all(view.point_at(QPointF(pixel.x() + x, pixel.y() + y)) for x in (-6, 6) for y in (-6, 6)):
            return pixel

def hand_pixel():
    hand = window.live.prepared.robot.link_index["hand"]
    for y in range(30, view.height() - 30, 5):
        for x in range(30, view.width() - 30, 5):
            body = view._body_along(view.display.actors.viewpoint.ray((x, y), view.display.size))
            if body is not None and body.number == hand:
                return QPoint(x, y)

def report_eye(_ms):
    report("eye", view.display.actors.viewpoint.eye.tolist())

def report_fingers(frame):
    report("fingers", [poke.id for poke in frame.pokes])

def report_menu(*_place):
    menu = window.presenters.pointing.menu
    menu.aboutToHide.connect(lambda: QTimer.singleShot(0, window, lambda: report("closed", True)))
    report("menu", [] if menu is None else [entry.objectName() for entry in menu.actions()])

def report_posture():
    editor = window.presenters.posture.editor
    report("posture", {"target": editor.target.tolist(), "gesture": editor.gesture})
    if window.views.tool.name == "posture":
        report("hand", on_screen(hand_pixel()))

def ready():
    window.activateWindow()  # there is no window manager that would
    window.hint_bar.hide()
    report("places", {"skin": on_screen(skin_pixel()), "home": window.live.prepared.robot.home.tolist()})

view.display.drawn.connect(report_eye)
window.live.frame_ready.connect(report_fingers)
window.views.menu_requested.connect(report_menu)
window.presenters.posture.editor.changed.connect(report_posture)
window.presenters.tools.changed.connect(lambda _tool: report_posture())
live(window, ready)
"""


def drag(app, start, by, button):
    """Press, move in small steps as a hand does, and release."""
    app.hand("mousemove", *start, "mousedown", button)
    for share in np.linspace(0, 1, 7)[1:]:
        app.hand("mousemove", *np.round(np.add(start, share * np.array(by))).astype(int), "sleep", 0.02)
    app.hand("mouseup", button)


def test_robot_view_responds_to_a_real_mouse(app):
    app.wait_for(lambda: app.read("places.json") and app.read("eye.json"))
    places = app.read("places.json")
    eye = app.read("eye.json")
    skin = places["skin"]

    app.hand("keydown", "shift", "mousemove", *skin, "click", 1, "keyup", "shift")
    app.wait_for(lambda: any(number > 1 for number in app.read("fingers.json") or []))
    assert app.read("eye.json") == eye, "a click turns nothing"

    app.hand("mousemove", *skin, "click", 3)
    app.wait_for(lambda: app.read("menu.json"))
    assert {"pointed-away", "pointed-force", "pointed-copy"} <= set(app.read("menu.json"))
    app.hand("key", "Escape")
    app.wait_for(lambda: app.read("closed.json"))  # a press while the menu is open would only close it

    drag(app, skin, (70, 25), 3)
    app.wait_for(lambda: np.linalg.norm(np.subtract(app.read("eye.json"), eye)) > 0.2)
    assert 1 not in app.read("fingers.json"), "nothing was poked"

    app.hand("key", "j")
    app.wait_for(lambda: app.read("hand.json"))
    drag(app, app.read("hand.json"), (25, -30), 1)

    def led():
        output = app.read("posture.json")
        return output["gesture"] == "" and np.abs(np.subtract(output["target"], places["home"])).max() > 0.01

    app.wait_for(led)
    assert app.read("fingers.json"), "the finger that was left is still there"

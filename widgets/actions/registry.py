"""Everything a person can ask of the window, in one table (name, text, shortcuts, tool tip), and the actions made from
it.

Shortcuts that are letters act only while one of the views has the focus. The list of keys and gestures is made from
the same table.
"""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from widgets.common.controller_settings import CONTROLLERS, SETTING_CHOICES


@dataclass(frozen=True)
class ActionSpec:
    """One action.

    Attributes:
        name: In code and for tests.
        text: In menus; a verb.
        keys: Shortcuts, the first is shown.
        tip: What it does.
        checkable: Whether it stays down.
        group: Of the actions of one group exactly one is down.
        in_views: Whether its keys act only while one of the views has the focus; so must all keys that are letters.
    """

    name: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checkable: bool = False
    group: str = ""
    in_views: bool = False


ACTIONS = (
    ActionSpec("open_robot", "Open robot…", ("Ctrl+O",), "Open MJCF, URDF or a bare mesh"),
    ActionSpec("open_scene", "Scene file…", (), "Open a scene of your own"),
    ActionSpec("save_scene", "Save scene as…", (), "Keep this scene, with the effects you chose"),
    ActionSpec("open_recording", "Open recording…", ("Ctrl+Shift+O",), "Replay a recording"),
    ActionSpec("import_taxels", "Import iCub taxels…", (), "Put the taxels of an iCub positions file on the robot"),
    ActionSpec("open_map", "Open map…", ("Ctrl+L",), "Take over the layout of a saved map of this skin"),
    ActionSpec("save_map", "Save map", ("Ctrl+S",), "Save the tactile map, with all that can be edited"),
    ActionSpec("save_map_as", "Save map as…", ("Ctrl+Shift+S",), "Save the tactile map under another name"),
    ActionSpec("export_map", "Export map…", ("Ctrl+E",), "For other programs: OBJ with UV, SVG, PNG, CSV and more"),
    ActionSpec("restore_map", "Restore", (), "Restore the edits that were not saved when the program ended"),
    ActionSpec("save_picture", "Save picture…", ("Ctrl+Shift+P",), "Save the window as a picture"),
    ActionSpec("quit", "Quit", ("Ctrl+Q",), "Close the window"),
    ActionSpec("pause", "Pause", ("Space",), "Stop or go on; in a replay, play or pause (Space)"),
    ActionSpec("step", "Step", (".",), "One control tick while paused (→ or .)"),
    ActionSpec("reset", "Reset", ("Backspace",), "Start the scene again (Backspace)"),
    ActionSpec("record", "Record", ("Ctrl+R",), "Record every tick to a file (Ctrl+R)", checkable=True),
    ActionSpec("undo", "Undo", ("Ctrl+Z",), "Undo the last edit of the map (Ctrl+Z)"),
    ActionSpec("redo", "Redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "Redo what was undone (Ctrl+Shift+Z)"),
    ActionSpec(
        "arrange",
        "Arrange patches",
        ("V",),
        "Click patches to select them, drag to move, rotate or scale them (V)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "pins",
        "Pins",
        ("N",),
        "Click the skin to pin it to the map, drag pins to pull the map (N)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "seams",
        "Seams",
        ("K",),
        "Draw along the skin, on body or map, where it is to be cut; Alt erases (K)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "interest",
        "Areas of interest",
        ("I",),
        "Paint where no seam may go; Alt erases, [ and ] change the brush (I)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "draw_path",
        "Path",
        ("D",),
        "Draw the path that the contact follows, on map or body; drag its corners (D)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "set_target",
        "Target",
        ("G",),
        "Click where the contact is to be held, on map or body; drag to move the target (G)",
        group="tool",
        in_views=True,
    ),
    *(
        ActionSpec(f"path_{kind}", text, (), tip, group="path")
        for kind, text, tip in (
            ("polyline", "Polyline", "Straight from corner to corner"),
            ("spline", "Spline", "Smoothly through all corners"),
            ("lemniscate", "Figure of eight", "Dragged from end to end"),
            ("raster", "Raster", "To and fro over a box"),
        )
    ),
    ActionSpec("clear_path", "Clear path and target", (), "Remove the drawn path and target"),
    ActionSpec("more_force", "More force", ("Alt+Up",), "Increase the force goal by 0.5 N (Alt+↑)"),
    ActionSpec("less_force", "Less force", ("Alt+Down",), "Decrease the force goal by 0.5 N (Alt+↓)"),
    ActionSpec("add_pin", "Pin", ("P",), "Pin the place under the pointer, or the selected taxels", in_views=True),
    ActionSpec("remove_pin", "Remove pins", ("Alt+P",), "Remove the selected pins, or the nearest", in_views=True),
    ActionSpec("select_pins", "Select pins", ("Shift+P",), "Select all pins of the selected patches", in_views=True),
    ActionSpec("propose_seam", "Propose a seam", ("Ctrl+K",), "Show where one more seam would help most, and how much"),
    ActionSpec("mirror", "Mirror", ("Ctrl+M",), "Mirror the selected patches horizontally"),
    *(
        ActionSpec(f"align_{name}", text, (), f"Line up the selected patches {where}")
        for name, text, where in (
            ("left", "Left sides", "by their left sides"),
            ("centre", "Middles, one above the other", "one above the other"),
            ("right", "Right sides", "by their right sides"),
            ("top", "Tops", "by their tops"),
            ("middle", "Middles, side by side", "side by side"),
            ("bottom", "Bottoms", "by their bottoms"),
        )
    ),
    ActionSpec("true_size", "True size", (), "Reset the scale of the selected patches to 1"),
    ActionSpec("repack", "Repack", ("Ctrl+Shift+K",), "Arrange patches as they sit on the body"),
    ActionSpec(
        "hide_patches", "Hide patches", ("H",), "Hide the selected patches; hidden patches keep sensing", in_views=True
    ),
    ActionSpec("show_patches", "Show all patches", ("Alt+H",), "Show every patch", in_views=True),
    ActionSpec("cancel_edit", "Cancel the edit", ("Ctrl+.",), "Cancel the edit that is being computed"),
    ActionSpec(
        "save_script", "Save my touches as a script…", (), "Keep your touches since the last reset, to play again"
    ),
    ActionSpec("play_script", "Play a script…", (), "Restart the scene and play a script of touches"),
    ActionSpec(
        "weigh", "Known-load check (0.1 kg)", (), "Lay 0.1 kg on the skin in a separate process: it must read 0.981 N"
    ),
    *(
        ActionSpec(f"controller_{controller}", text, (f"Alt+{number}",), f"{tip} (Alt+{number})", group="controller")
        for number, (controller, (text, tip)) in enumerate(CONTROLLERS.items(), start=1)
    ),
    *(
        ActionSpec(f"task_{task}", text, (), f"{text}, with the controllers that do tasks", group="task")
        for task, text in SETTING_CHOICES["task"][1].items()
    ),
    ActionSpec("start_again", "Restart task", ("Ctrl+Backspace",), "From its beginning (Ctrl+Backspace)"),
    ActionSpec("reset_gains", "Reset gains", (), "Reset all gains of the controller to the scene's values"),
    ActionSpec(
        "compare_controllers",
        "Compare controllers…",
        ("Ctrl+Shift+L",),
        "Run several controllers on the same stimuli in another process",
    ),
    ActionSpec("save_report", "Save report", (), "Save a report that replays what led to the stop"),
    ActionSpec("use_anyway", "Use anyway", (), "Simulate it in spite of the warning"),
    ActionSpec("poke", "Poke", ("T",), "Press the skin to poke it (T)", group="tool", in_views=True),
    ActionSpec(
        "select_box",
        "Select by box",
        ("B",),
        "Click taxels, or drag a box around them; Ctrl or Shift adds, Alt removes (B)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "select_lasso",
        "Select by lasso",
        ("L",),
        "Click taxels, or draw a line around them; Ctrl or Shift adds, Alt removes (L)",
        group="tool",
        in_views=True,
    ),
    ActionSpec(
        "select_brush",
        "Select by brush",
        ("C",),
        "Paint over taxels; [ and ] change the brush, Ctrl or Shift adds, Alt removes (C)",
        group="tool",
        in_views=True,
    ),
    ActionSpec("smaller_brush", "Smaller brush", ("[",), "Make the brush that selects smaller", in_views=True),
    ActionSpec("larger_brush", "Larger brush", ("]",), "Make the brush that selects larger", in_views=True),
    ActionSpec("select_all", "Select all", ("A",), "Select every taxel", in_views=True),
    ActionSpec("select_none", "Select none", ("Alt+A",), "Select no taxel (Escape)", in_views=True),
    ActionSpec("select_inverse", "Invert selection", ("Ctrl+I",), "Select the taxels that are not selected"),
    ActionSpec(
        "morph",
        "Body or map",
        ("M",),
        "Flatten the skin in the robot view, or put it back on the body (M)",
        in_views=True,
    ),
    *(
        ActionSpec(f"ground_{name}", text, (f"Ctrl+{number}",), f"{tip} (Ctrl+{number})", group="ground")
        for number, (name, text, tip) in enumerate(
            (
                ("pressure", "Pressure", "Show pressure only"),
                (
                    "angle",
                    "Angle distortion",
                    "Ratio of the larger to the smaller stretch at each point (1: no angle distortion)",
                ),
                ("area", "Area distortion", "Ratio of map area to body area at each point (1: no area distortion)"),
                ("checker", "Checker", "Checkerboard on the map, shown on the body as the map distorts it"),
                ("circles", "Circles", "Circles on the body, shown on the map as ellipses (Tissot's indicatrix)"),
            ),
            start=1,
        )
    ),
    ActionSpec("mark_seams", "Seams", ("Alt+S",), "Show the seams along which the skin was cut", checkable=True),
    ActionSpec("mark_border", "Border", ("Alt+B",), "Show the border of the skin", checkable=True),
    ActionSpec("mark_pins", "Pins", (), "Show the pins whatever the tool", checkable=True),
    ActionSpec("mark_contours", "Contours", ("Alt+C",), "Show the outlines of contact regions", checkable=True),
    ActionSpec(
        "mark_shapes",
        "Contact shapes",
        (),
        "Dash each contact's ellipse, and dot the circle in which its centre lies, where they are large enough",
        checkable=True,
    ),
    ActionSpec(
        "mark_taxel_ids", "Taxel numbers", ("Alt+N",), "Number the taxels, as many as have room", checkable=True
    ),
    ActionSpec(
        "mark_dots",
        "Taxels as dots",
        ("Alt+D",),
        "A dot for each taxel, instead of a picture between them",
        checkable=True,
    ),
    ActionSpec("compare", "Other layout", ("Ctrl+D",), "Show the layout that is compared with, or ours again"),
    ActionSpec("theme", "Light theme", ("Ctrl+Shift+T",), "Dark or light", checkable=True),
    ActionSpec("panels", "Panels", ("F2",), "Show or hide the panels", checkable=True),
    ActionSpec("timing", "Timing", ("F3",), "Show where the time goes"),
    ActionSpec("effects", "Effects", ("F5",), "Show what is simulated, why, and what it costs"),
    ActionSpec("plots", "Timeline and plots", ("F4",), "Show or hide what is below the views", checkable=True),
    ActionSpec("full_screen", "Full screen", ("F11",), "The whole screen", checkable=True),
    ActionSpec("reset_layout", "Reset layout", (), "Both views equally wide, all panels shown"),
    ActionSpec("frame", "Frame all", ("Home",), "Show the whole robot and the whole map (Home)"),
    ActionSpec("keys", "Keys", ("F1", "?"), "List the keys"),
    ActionSpec("about", "About Tactile Maps", (), "Versions"),
)

MOUSE_GESTURES = (
    ("Press the skin or the map", "poke; force grows while held"),
    ("Drag along it", "stroke"),
    ("Escape", "release the poke, cancel a selection being drawn, or select none"),
    ("Click, or drag around, with Select", "select taxels, on the map or on the body"),
    ("Drag a patch with Arrange", "move it; its corners scale, its handle rotates; Ctrl does not snap"),
    ("Drag a pin with Pins", "the map follows; click the skin to pin it"),
    ("Drag along the skin with Seams", "draw a seam; Alt erases one"),
    ("Enter, Escape", "accept or decline a proposed seam"),
    ("Click or drag with Path", "draw; Enter or a double click ends, Backspace removes the last corner"),
    ("Drag a path's corner, side or line", "move it, add a corner, move all of it; Delete removes a corner"),
    ("Click or drag with Target", "hold the contact there, move it along"),
    ("Wheel or drag on the force, Page Up and Down", "0.5 N more or less, with Path and Target"),
    ("→", "one control tick while paused, or one frame of a replay"),
    ("Drag beside the robot", "turn the view; with Shift, move it"),
    ("Drag beside the map, or Space-drag", "move the map"),
    ("Wheel", "zoom"),
    ("Click a side of the cube", "look from there"),
    ("Double-click beside robot or map", "frame all"),
)


def make_actions(parent: QWidget) -> dict[str, QAction]:
    """The actions, owned by ``parent`` and active in its window; those ``in_views`` wait for ``give_views_keys``."""
    made: dict[str, QAction] = {}
    groups: dict[str, QActionGroup] = {}
    for spec in ACTIONS:
        action = QAction(spec.text, parent)
        action.setObjectName(f"action-{spec.name}")
        action.setShortcuts([QKeySequence(keys) for keys in spec.keys])
        action.setToolTip(spec.tip)
        action.setStatusTip(spec.tip)
        action.setCheckable(spec.checkable or bool(spec.group))
        if spec.group:
            groups.setdefault(spec.group, QActionGroup(parent)).addAction(action)
        if spec.in_views:
            action.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        else:
            parent.addAction(action)
        made[spec.name] = action
    return made


def add_view_shortcuts(views: QWidget, actions: dict[str, QAction]) -> None:
    """Let the keys of the actions ``in_views`` act while ``views`` has the focus."""
    for spec in ACTIONS:
        if spec.in_views:
            views.addAction(actions[spec.name])


def shortcuts_html() -> str:
    """All keys and gestures as a small HTML table."""
    rows = [(spec.keys[0], spec.text.rstrip("…")) for spec in ACTIONS if spec.keys]
    lines = "".join(
        f"<tr><td><b>{keys}</b>&nbsp;&nbsp;&nbsp;</td><td>{text}</td></tr>" for keys, text in (*rows, *MOUSE_GESTURES)
    )
    return f"<table cellspacing='4'>{lines}</table>"

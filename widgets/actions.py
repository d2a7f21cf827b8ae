"""Everything a person can ask of the window, in one table: name, words, keys, tool tip."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QWidget


@dataclass(frozen=True)
class ActionSpec:
    """One action.

    Attributes:
        name: In code and for tests.
        text: In menus; a verb.
        keys: Shortcuts, the first is shown.
        tip: What it does.
        checkable: Whether it stays down.
    """

    name: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checkable: bool = False


ACTIONS = (
    ActionSpec("open_robot", "Open robot…", ("Ctrl+O",), "Open MJCF, URDF or a bare mesh"),
    ActionSpec("open_recording", "Open recording…", ("Ctrl+Shift+O",), "Replay a recording"),
    ActionSpec("import_taxels", "Import iCub taxels…", (), "Wear the taxels of an iCub positions file"),
    ActionSpec("save_map", "Save map…", ("Ctrl+S",), "Save the tactile map as .npz, or as .obj with UV"),
    ActionSpec("save_picture", "Save picture…", ("Ctrl+Shift+S",), "Save the window as a picture"),
    ActionSpec("quit", "Quit", ("Ctrl+Q",), "Close the window"),
    ActionSpec("pause", "Pause", ("Space",), "Stop or go on; in a replay, play or pause (Space)"),
    ActionSpec("step", "Step", (".",), "One control tick while paused (→ or .)"),
    ActionSpec("reset", "Reset", ("Backspace",), "Start the scene again (Backspace)"),
    ActionSpec("record", "Record", ("Ctrl+R",), "Record every tick to a file (Ctrl+R)", checkable=True),
    ActionSpec("theme", "Light theme", ("Ctrl+Shift+T",), "Dark or light", checkable=True),
    ActionSpec("panels", "Panels", ("F2",), "Show or hide the panels", checkable=True),
    ActionSpec("timing", "Timing", ("F3",), "Show where the time goes"),
    ActionSpec("plots", "Timeline and plots", ("F4",), "Show or hide what is below the views", checkable=True),
    ActionSpec("full_screen", "Full screen", ("F11",), "The whole screen", checkable=True),
    ActionSpec("reset_layout", "Reset layout", (), "Both views equally wide, all panels shown"),
    ActionSpec("frame", "Frame all", ("Home",), "Show the whole robot and the whole map (Home)"),
    ActionSpec("keys", "Keys", ("F1", "?"), "List the keys"),
    ActionSpec("about", "About Tactile Maps", (), "Versions"),
)

MOUSE = (
    ("Press the skin or the map", "poke; force grows while held"),
    ("Drag along it", "stroke"),
    ("Escape", "lift the finger"),
    ("→", "one control tick while paused, or one frame of a replay"),
    ("Drag beside the robot", "turn the view; with Shift, move it"),
    ("Drag beside the map, or Space-drag", "move the map"),
    ("Wheel", "zoom"),
    ("Double-click beside robot or map", "frame all"),
)


def make_actions(parent: QWidget) -> dict[str, QAction]:
    """The actions, owned by ``parent`` and active in its window."""
    made = {}
    for spec in ACTIONS:
        action = QAction(spec.text, parent)
        action.setObjectName(f"action-{spec.name}")
        action.setShortcuts([QKeySequence(keys) for keys in spec.keys])
        action.setToolTip(spec.tip)
        action.setStatusTip(spec.tip)
        action.setCheckable(spec.checkable)
        parent.addAction(action)
        made[spec.name] = action
    return made


def keys_text() -> str:
    """All keys and gestures as a small HTML table."""
    rows = [(spec.keys[0], spec.text.rstrip("…")) for spec in ACTIONS if spec.keys]
    lines = "".join(
        f"<tr><td><b>{keys}</b>&nbsp;&nbsp;&nbsp;</td><td>{text}</td></tr>" for keys, text in (*rows, *MOUSE)
    )
    return f"<table cellspacing='4'>{lines}</table>"

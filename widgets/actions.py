"""The window's actions, made from their table."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

from widgets.action_table import ACTIONS, MOUSE


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


def give_views_keys(views: QWidget, actions: dict[str, QAction]) -> None:
    """Let the keys of the actions ``in_views`` act while ``views`` has the focus."""
    for spec in ACTIONS:
        if spec.in_views:
            views.addAction(actions[spec.name])


def keys_text() -> str:
    """All keys and gestures as a small HTML table."""
    rows = [(spec.keys[0], spec.text.rstrip("…")) for spec in ACTIONS if spec.keys]
    lines = "".join(
        f"<tr><td><b>{keys}</b>&nbsp;&nbsp;&nbsp;</td><td>{text}</td></tr>" for keys, text in (*rows, *MOUSE)
    )
    return f"<table cellspacing='4'>{lines}</table>"

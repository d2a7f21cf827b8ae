"""Filter of wheel events: over a control without focus, the wheel scrolls the panel and does not change the value."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtWidgets import QAbstractSpinBox, QComboBox, QSlider, QWidget

_KINDS = (QComboBox, QSlider, QAbstractSpinBox)


class _WheelGuard(QObject):
    """Event filter of one control."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QWidget) and not watched.hasFocus():
            event.ignore()
            return True
        return False


def guard_wheel(root: QWidget) -> None:
    """Let combo boxes, sliders and number fields in ``root``, and ``root`` itself, use the wheel only with the focus.

    Controls created later need another call; a second call for the same control changes nothing.
    """
    inside = [control for kind in _KINDS for control in root.findChildren(kind)]
    for control in (*([root] if isinstance(root, _KINDS) else []), *inside):
        if control.findChild(_WheelGuard, options=Qt.FindChildOption.FindDirectChildrenOnly) is None:
            control.installEventFilter(_WheelGuard(control))
            if control.focusPolicy() == Qt.FocusPolicy.WheelFocus:
                control.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

"""The wheel over a control that a person has not clicked scrolls what it stands in, and changes nothing unseen."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtWidgets import QAbstractSpinBox, QComboBox, QSlider, QWidget

_KINDS = (QComboBox, QSlider, QAbstractSpinBox)


class _WheelGuard(QObject):
    """Of one control."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: the wheel is for whoever stands around a control without the keyboard."""
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QWidget) and not watched.hasFocus():
            event.ignore()
            return True
        return False


def guard_wheel(root: QWidget) -> None:
    """Have all drop-downs, sliders and number fields in ``root``, itself included, take the wheel only when focused.

    Controls made later need a call of their own; a second call for the same control changes nothing.
    """
    inside = [control for kind in _KINDS for control in root.findChildren(kind)]
    for control in (*([root] if isinstance(root, _KINDS) else []), *inside):
        if control.findChild(_WheelGuard, options=Qt.FindChildOption.FindDirectChildrenOnly) is None:
            control.installEventFilter(_WheelGuard(control))
            if control.focusPolicy() == Qt.FocusPolicy.WheelFocus:
                control.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

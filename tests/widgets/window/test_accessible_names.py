"""Every control of the window has a name that a screen reader can say."""

from __future__ import annotations

from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QHeaderView,
    QLineEdit,
    QScrollBar,
    QWidget,
)

from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tactile_widgets.views.colour_bar import ColourBar

KINDS = (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    ColourBar,
    ScrubBar,
)
PARTS = (QScrollBar, QHeaderView)
"""Parts of controls that have a name."""


def named(control: QWidget) -> bool:
    """Whether a control has a name, a text, or a parent control with a name."""
    words = control.text() if isinstance(control, QAbstractButton) else ""
    around = control.parentWidget()
    part = control.objectName().startswith("qt_") or isinstance(around, (QComboBox, QAbstractSpinBox, QLineEdit))
    return bool(control.accessibleName() or words or part)


def test_every_control_has_a_name(window_again):
    window_again.action("keys").trigger()
    controls = [found for kind in KINDS for found in window_again.findChildren(kind)]
    windows = (window_again, window_again._commands._sheet)
    controls = [one for one in controls if not isinstance(one, PARTS) and one.window() in windows]
    assert len(controls) > 100
    nameless = [one for one in controls if not named(one) and one.parentWidget().objectName() != "message-bar"]
    unnamed = sorted(
        f"{type(one).__name__} {one.objectName()}" for one in nameless
    )  # a message gives its buttons words
    window_again._commands._sheet.close()
    assert not unnamed

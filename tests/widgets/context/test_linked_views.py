"""Both views show one instant, and the one under the finger shows it first."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject

from app.session.session import Session


class Paints(QObject):
    """Counts a widget's paint events."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        self.count += event.type() == QEvent.Type.Paint
        return False


def test_the_map_is_painted_before_a_frame_is_done_with(window, prepared):
    """It is what the finger waits for: no round of events lies between, in which the body could be drawn first."""
    frame = Session(prepared, scripted=False).tick()
    viewport, paints = window.map_view.viewport(), Paints()
    viewport.installEventFilter(paints)
    window.views.show_frame(frame)
    viewport.removeEventFilter(paints)
    assert paints.count == 1

"""The column of panels beside the views."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QScrollArea, QVBoxLayout, QWidget

from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.panels.contacts_panel import ContactsPanel
from widgets.panels.controller_panel import ControllerPanel
from widgets.panels.effects_panel import EffectsPanel
from widgets.panels.quality_panel import QualityPanel
from widgets.panels.timing_panel import TimingPanel

WIDTH = 300
_SLIM = """
    QScrollBar:vertical { width: 8px; margin: 0; background: transparent; border: 0; }
    QScrollBar::handle:vertical { background: palette(mid); border-radius: 4px; min-height: 32px; }
    QScrollBar::add-line:vertical, QScrollBar::sub-line:vertical { height: 0; }
    QScrollBar::add-page:vertical, QScrollBar::sub-page:vertical { background: transparent; }
"""


class PanelColumn(QScrollArea):
    """All panels, one below the other; they scroll, the views never shrink for them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.controller, self.contacts, self.quality = ControllerPanel(), ContactsPanel(), QualityPanel()
        self.timing, self.effects = TimingPanel(), EffectsPanel()
        content = QWidget()
        self._rows = QVBoxLayout(content)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(4)
        for panel in (self.controller, self.contacts, self.quality, self.timing, self.effects):
            self._rows.addWidget(panel)
        self._rows.addStretch(1)
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFixedWidth(WIDTH)
        self.verticalScrollBar().setStyleSheet(_SLIM)

    def reveal(self, panel: QWidget) -> None:
        """Scroll so that all of ``panel`` can be seen."""
        self._rows.activate()  # they may have been hidden until now
        self.ensureWidgetVisible(panel, 0, 0)

    def show_prepared(self, prepared: Prepared) -> None:
        """Another scene."""
        self.effects.show_prepared(prepared)
        self.quality.show_prepared(prepared)
        self.contacts.clear()
        self.timing.clear()

    def show_frame(self, frame: Frame) -> None:
        """Another instant."""
        for panel in (self.contacts, self.controller, self.timing):
            panel.show_frame(frame)

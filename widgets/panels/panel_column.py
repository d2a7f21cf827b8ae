"""The column of panels beside the views."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import QScrollArea, QVBoxLayout, QWidget

from app.session.frame import Frame
from app.session.prepare import PreparedScene
from widgets.common.panel import SLIM_SCROLL_BAR, Panel
from widgets.document.map_editor import MapEditor
from widgets.document.taxel_selection import TaxelSelection
from widgets.panels.accuracy_panel import AccuracyPanel
from widgets.panels.behaviours_panel import BehavioursPanel
from widgets.panels.compare_panel import ComparePanel
from widgets.panels.contacts_panel import ContactsPanel
from widgets.panels.controller_panel import ControllerPanel
from widgets.panels.effects_panel import EffectsPanel
from widgets.panels.events_panel import EventsPanel
from widgets.panels.history_panel import HistoryPanel
from widgets.panels.patches_panel import PatchesPanel
from widgets.panels.quality_panel import QualityPanel
from widgets.panels.timing_panel import TimingPanel
from widgets.session.live_session import LiveSession

COLUMN_WIDTH = 300
FOLDED_AT_FIRST = ("behaviours-panel", "compare-panel", "history-panel", "accuracy-panel")
"""What a person looks for when it is needed."""


class PanelColumn(QScrollArea):
    """All panels, one below the other; they scroll, the views never shrink for them.

    What the arm does is at the top, then the map, from what is edited to how good that is, then what it all costs.

    Args:
        editor: Of the map.
        parent: Qt parent.
    """

    folded_changed = Signal(object)
    """The names of the panels that are folded now, as a tuple: what the hand left, for the settings."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.controller, self.contacts, self.quality = ControllerPanel(), ContactsPanel(), QualityPanel()
        self.patches, self.compare, self.history = PatchesPanel(editor), ComparePanel(editor), HistoryPanel(editor)
        self.accuracy, self.timing, self.effects = AccuracyPanel(), TimingPanel(), EffectsPanel()
        self.events, self.behaviours = EventsPanel(), BehavioursPanel()
        self._panels: list[Panel] = []
        content = QWidget()
        self._rows = QVBoxLayout(content)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(4)
        self._rows.addStretch(1)
        for panel in (
            self.controller, self.contacts, self.events, self.behaviours, self.patches, self.quality, self.compare,
            self.history, self.accuracy, self.timing, self.effects,
        ):  # fmt: skip
            self.add(panel)
        self.compare.compared.connect(self.quality.show_comparison)
        self.compare.ended.connect(self.quality.end_comparison)
        self.set_folded(FOLDED_AT_FIRST)
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFixedWidth(COLUMN_WIDTH)
        self.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)

    @property
    def folded(self) -> tuple[str, ...]:
        """The names of the panels of which only the heading is shown."""
        return tuple(panel.objectName() for panel in self._panels if panel.folded)

    def set_folded(self, names: Iterable[str]) -> None:
        """Fold these panels, and no others."""
        wanted = set(names)
        for panel in self._panels:
            panel.set_folded(panel.objectName() in wanted)

    def add(self, panel: Panel, *, below: Panel | None = None) -> None:
        """Put in another panel, at the end or below one that is there."""
        place = len(self._panels) if below is None else self._panels.index(below) + 1
        self._panels.insert(place, panel)
        self._rows.insertWidget(place, panel)
        panel.folded_changed.connect(self._on_folded_changed)

    def reveal(self, panel: Panel) -> None:
        """Unfold ``panel``, and scroll so that all of it can be seen."""
        if panel.folded:
            panel.set_folded(False)
            self._on_folded_changed()
        self._rows.activate()  # they may have been hidden until now
        self.ensureWidgetVisible(panel, 0, 0)
        # Lines that wrap know their height only once they are shown.
        QTimer.singleShot(0, panel, lambda: self.ensureWidgetVisible(panel, 0, 0))

    def follow(self, live: LiveSession, selection: TaxelSelection) -> None:
        """Show what ``live`` tells, ask it for what a person wants, and share what is selected."""
        live.measured.connect(self.quality.show_quality)
        live.settings_changed.connect(self.controller.show_settings)
        live.behaviours_changed.connect(self.behaviours.show_behaviours)
        live.triggered.connect(self.behaviours.show_triggered)
        live.reading_changed.connect(self.contacts.show_reading)
        live.effects_changed.connect(self.contacts.show_effects)
        self.contacts.reading_edited.connect(live.set_reading)
        live.mode_changed.connect(self._on_mode_changed)
        self.controller.settings_edited.connect(live.set_settings)
        self.behaviours.behaviours_edited.connect(live.set_behaviours)
        self.contacts.follow(selection)

    def _on_mode_changed(self, mode: str) -> None:
        """What is replayed cannot be changed."""
        for panel in (self.controller, self.behaviours):
            panel.setEnabled(mode in ("live", "paused"))
        self.contacts.set_editable(editable=mode in ("live", "paused"))

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another scene."""
        self.controller.show_prepared(prepared)
        self.effects.show_prepared(prepared)
        self.quality.show_prepared(prepared)
        self.accuracy.show_prepared(prepared)
        self.behaviours.show_prepared(prepared)
        self.contacts.clear()
        self.events.clear()
        self.timing.clear()

    def show_frame(self, frame: Frame) -> None:
        """Another instant."""
        for panel in (self.contacts, self.events, self.controller, self.timing, self.effects):
            panel.show_frame(frame)

    def _on_folded_changed(self) -> None:
        self.folded_changed.emit(self.folded)

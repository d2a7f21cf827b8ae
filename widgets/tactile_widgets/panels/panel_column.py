"""The column of panels next to the views."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import TypeVar

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtWidgets import QScrollArea, QVBoxLayout, QWidget

from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.guide_window import GuidePlace
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.panels.registry import PANELS, PanelSpec
from tactile_widgets.session.session_host import SessionHost

COLUMN_WIDTH = 300
_NOT_SIMULATED = "A real skin is connected, and nothing is simulated: disconnect it to change this."
_WAS_NOT_SIMULATED = "This is a recording of a real skin: nothing was simulated."

P = TypeVar("P", bound=Panel)


class PanelColumn(QScrollArea):
    """All panels, one below the other; they scroll, and the views do not shrink for them.

    Args:
        editor: Editor of the map.
        parent: Qt parent.
        specs: Panels from top to bottom.
    """

    help_requested = Signal(GuidePlace)
    """Open the guide at this place."""
    undock_requested = Signal(Panel)
    """Move this panel to a separate window, or back."""
    folded_changed = Signal(tuple)
    """Names of the folded panels, for the settings."""

    def __init__(
        self, editor: MapEditor, parent: QWidget | None = None, *, specs: Sequence[PanelSpec] = PANELS
    ) -> None:
        super().__init__(parent)
        self._specs = tuple(specs)
        self._panels = list[Panel]()
        content = QWidget()
        self._rows = QVBoxLayout(content)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(4)
        for spec in specs:
            panel = spec.make(editor, self)
            panel.set_folded(spec.folded_at_first)
            panel.folded_changed.connect(self._on_folded_changed)
            panel.help_requested.connect(partial(self.help_requested.emit, spec.guide))
            panel.undock_requested.connect(partial(self.undock_requested.emit, panel))
            self._panels.append(panel)
            self._rows.addWidget(panel)
        self._rows.addStretch(1)
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFixedWidth(COLUMN_WIDTH)
        self.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)

    def get(self, kind: type[P]) -> P:
        """Return the panel of a class."""
        return next(panel for panel in self._panels if isinstance(panel, kind))

    def __getitem__(self, name: str) -> Panel:
        """Return the panel with this name, which is its object name without ``-panel``."""
        return next(panel for panel in self._panels if panel.objectName() == f"{name}-panel")

    def __iter__(self) -> Iterator[Panel]:
        """Iterate over all panels from top to bottom, including undocked ones."""
        return iter(self._panels)

    def put_back(self, panel: Panel) -> None:
        """Return an undocked panel to its place in the column."""
        before = self._panels[: self._panels.index(panel)]
        panel.undocked = False
        self._rows.insertWidget(sum(not other.undocked for other in before), panel)
        panel.show()

    @property
    def folded(self) -> tuple[str, ...]:
        """Names of the folded panels."""
        return tuple(panel.objectName() for panel in self._panels if panel.folded)

    def set_folded(self, names: Iterable[str]) -> None:
        """Fold these panels, and unfold all others."""
        folded = set(names)
        for panel in self._panels:
            panel.set_folded(panel.objectName() in folded)

    def reveal(self, panel: Panel) -> None:
        """Unfold a panel and scroll to it."""
        if panel.folded:
            panel.set_folded(False)
            self._on_folded_changed()
        if panel.undocked:
            panel.window().raise_()
            return
        self._rows.activate()  # panels may have been hidden until now
        self.ensureWidgetVisible(panel, 0, 0)
        # Labels that wrap know their height only once they are shown.
        QTimer.singleShot(0, panel, lambda: self.ensureWidgetVisible(panel, 0, 0))

    def follow(self, session: SessionHost, selection: TaxelSelection) -> None:
        """Connect the panels to a session, in both directions, and to the selection."""
        for spec, panel in zip(self._specs, self._panels, strict=True):
            if spec.follow is not None:
                spec.follow(panel, session, selection)
        self._session = session
        session.mode_changed.connect(self._on_mode_changed)

    def _on_mode_changed(self, mode: Mode) -> None:
        """Disable what a replay, or a real skin, does not allow to change."""
        running = mode.takes_input
        reason = ""
        if running and self._session.live_input is not None:
            reason = _NOT_SIMULATED
        elif (player := self._session.replay.player) is not None and player.measured is not None:
            reason = _WAS_NOT_SIMULATED
        for panel in self._panels:
            panel.set_editable(editable=running and not (panel.simulates and reason))
            if panel.simulates:
                panel.show_reason(reason)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another scene."""
        for panel in self._panels:
            panel.show_prepared(prepared)

    def show_frame(self, frame: Frame) -> None:
        """Show another instant."""
        for panel in self._panels:
            panel.show_frame(frame)

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        for panel in self._panels:
            panel.set_theme(theme)

    def _on_folded_changed(self) -> None:
        self.folded_changed.emit(self.folded)

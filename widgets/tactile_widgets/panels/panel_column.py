"""The column of panels next to the views."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import TypeVar

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtWidgets import QScrollArea, QSizePolicy, QStackedWidget, QTabBar, QWidget

from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.guide_window import GuidePlace
from tactile_widgets.common.make import column_layout, make
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.jobs.later import call_later
from tactile_widgets.panels.registry import PANELS, PanelSpec, PanelTab
from tactile_widgets.session.live_input import LiveInput
from tactile_widgets.session.session_host import SessionHost

COLUMN_WIDTH = 300
_NO_SESSION = "Open a robot or a scene first."
_NOT_SIMULATED = "A real skin is connected, and nothing is simulated: disconnect it to change this."
_WAS_NOT_SIMULATED = "This is a recording of a real skin: nothing was simulated."

P = TypeVar("P", bound=Panel)


class _Page(QScrollArea):
    """The panels of one tab, one below the other."""

    def __init__(self) -> None:
        super().__init__()
        self._content = content = QWidget()
        # A text that is too long is cut; otherwise it would widen the page, whose right side would be cut off.
        content.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._rows = column_layout(None, parent=content, spacing=4)
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)

    def add(self, panel: Panel, *, row: int | None = None) -> None:
        """Insert a panel, by default below the others."""
        self._rows.insertWidget(self._rows.count() - 1 if row is None else row, panel)

    def scroll_to(self, widget: QWidget) -> None:
        """Scroll until a panel or a control is visible, or its upper part if it is higher than the page."""
        self._rows.activate()  # panels may have been hidden until now
        self._scroll_to(widget)
        # Labels that wrap know their height only once they are shown.
        call_later(widget, lambda: self._scroll_to(widget))

    def _scroll_to(self, widget: QWidget) -> None:
        self.ensureWidgetVisible(widget, 0, 0)
        bar = self.verticalScrollBar()
        bar.setValue(min(bar.value(), widget.mapTo(self._content, QPoint(0, 0)).y()))


class PanelColumn(QWidget):
    """All panels, on a few tabs; on each tab they scroll, and the views do not shrink for them.

    The tabs of a connected skin are shown only while one is connected.

    Args:
        editor: Editor of the map.
        parent: Qt parent.
        specs: Panels from top to bottom, with the tab of each.
    """

    help_requested = Signal(GuidePlace)
    """Open the guide at this place."""
    undock_requested = Signal(Panel)
    """Move this panel to a separate window, or back."""
    folded_changed = Signal(tuple)
    """Names of the folded panels, for the settings."""
    tab_changed = Signal(PanelTab)
    """Another tab is shown."""

    def __init__(
        self, editor: MapEditor, parent: QWidget | None = None, *, specs: Sequence[PanelSpec] = PANELS
    ) -> None:
        super().__init__(parent)
        self._specs = tuple(specs)
        self._panels = list[Panel]()
        self._tabs = make(
            QTabBar,
            self,
            objectName="panel-tabs",
            accessibleName="Panels",
            drawBase=False,
            expanding=True,
            usesScrollButtons=False,
        )
        self._pages = QStackedWidget(self)
        self._shown = [tab for tab in PanelTab if any(spec.tab is tab for spec in specs)]
        for tab in self._shown:
            self._tabs.addTab(tab.value)
            self._tabs.setTabToolTip(self._tabs.count() - 1, tab.tip)
            self._pages.addWidget(_Page())
        for spec in specs:
            panel = spec.make(editor, self)
            panel.set_folded(spec.folded_at_first)
            panel.folded_changed.connect(self._on_folded_changed)
            panel.help_requested.connect(partial(self.help_requested.emit, spec.guide))
            panel.undock_requested.connect(partial(self.undock_requested.emit, panel))
            self._panels.append(panel)
            self._page(spec.tab).add(panel)
        column_layout(self._tabs, self._pages, parent=self, spacing=0)
        self._tabs.currentChanged.connect(self._on_current_changed)
        self._before_live = next((tab for tab in self._shown if tab is not PanelTab.LIVE), PanelTab.LIVE)
        self.set_live(live=False)
        self.setFixedWidth(COLUMN_WIDTH)

    def get(self, kind: type[P]) -> P:
        """Return the panel of a class."""
        return next(panel for panel in self._panels if isinstance(panel, kind))

    def __getitem__(self, name: str) -> Panel:
        """Return the panel with this name, which is its object name without ``-panel``."""
        return next(panel for panel in self._panels if panel.objectName() == f"{name}-panel")

    def __iter__(self) -> Iterator[Panel]:
        """Iterate over all panels, tab by tab and from top to bottom, including undocked ones."""
        return iter(self._panels)

    # Tabs.

    @property
    def tab(self) -> PanelTab:
        """The tab that is shown."""
        return self._shown[self._tabs.currentIndex()]

    def show_tab(self, tab: PanelTab) -> None:
        """Show a tab, unless it is hidden."""
        number = self._shown.index(tab)
        if self._tabs.isTabVisible(number):
            self._tabs.setCurrentIndex(number)

    def set_live(self, *, live: bool) -> None:
        """Show and select the tab of a connected skin, or hide it and return to the previous tab."""
        if PanelTab.LIVE not in self._shown:
            return
        number = self._shown.index(PanelTab.LIVE)
        if live == self._tabs.isTabVisible(number):
            return
        if live:
            self._before_live = self.tab
            self._tabs.setTabVisible(number, True)
            self.show_tab(PanelTab.LIVE)
        else:
            selected = self.tab is PanelTab.LIVE
            self._tabs.setTabVisible(number, False)
            if selected:
                self.show_tab(self._before_live)

    def _on_current_changed(self, number: int) -> None:
        self._pages.setCurrentIndex(number)
        self.tab_changed.emit(self.tab)

    def _page(self, tab: PanelTab) -> _Page:
        page = self._pages.widget(self._shown.index(tab))
        assert isinstance(page, _Page)
        return page

    def page_of(self, panel: Panel) -> QScrollArea:
        """Return the scroll area of a panel's tab."""
        return self._page(self._specs[self._panels.index(panel)].tab)

    def put_back(self, panel: Panel) -> None:
        """Return an undocked panel to its place in the column."""
        number = self._panels.index(panel)
        tab = self._specs[number].tab
        above = [
            other
            for spec, other in zip(self._specs[:number], self._panels[:number], strict=True)
            if spec.tab is tab and not other.undocked
        ]
        panel.undocked = False
        self._page(tab).add(panel, row=len(above))
        panel.show()
        before = next((other for other in reversed(self._panels[:number]) if not other.undocked), self._tabs)
        QWidget.setTabOrder(before, panel)  # Qt puts a widget that changes its window last

    @property
    def folded(self) -> tuple[str, ...]:
        """Names of the folded panels."""
        return tuple(panel.objectName() for panel in self._panels if panel.folded)

    def set_folded(self, names: Iterable[str]) -> None:
        """Fold these panels, and unfold all others."""
        folded = set(names)
        for panel in self._panels:
            panel.set_folded(panel.objectName() in folded)

    def reveal(self, panel: Panel, control: QWidget | None = None) -> None:
        """Show the tab of a panel, unfold it and scroll to it, or to a control in it."""
        if panel.folded:
            panel.set_folded(False)
            self._on_folded_changed()
        if panel.undocked:
            panel.window().raise_()
            return
        spec = self._specs[self._panels.index(panel)]
        self.show_tab(spec.tab)
        self._page(spec.tab).scroll_to(control or panel)

    def follow(self, session: SessionHost, selection: TaxelSelection) -> None:
        """Connect the panels to a session, in both directions, and to the selection."""
        for spec, panel in zip(self._specs, self._panels, strict=True):
            if spec.follow is not None:
                spec.follow(panel, session, selection)
        self._session = session
        session.mode_changed.connect(self._on_mode_changed)
        session.connection.changed.connect(self._on_connection_changed)
        self._on_mode_changed(session.mode)

    def _on_connection_changed(self, live: LiveInput | None) -> None:
        self.set_live(live=live is not None)

    def _on_mode_changed(self, mode: Mode) -> None:
        """Disable what cannot be changed without a session, in a replay, or with a real skin."""
        reason = ""
        if mode is Mode.EMPTY:
            reason = _NO_SESSION
        elif mode.takes_input and self._session.live_input is not None:
            reason = _NOT_SIMULATED
        elif (player := self._session.replay.player) is not None and player.measured is not None:
            reason = _WAS_NOT_SIMULATED
        for panel in self._panels:
            panel.set_editable(editable=mode is not Mode.REPLAYING and not (panel.simulates and reason))
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

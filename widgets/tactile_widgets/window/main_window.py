"""Main window: creates views, panels, bars and presenters, and connects them. It holds no logic."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from PySide6.QtCore import QCoreApplication, QEvent, QRect, QSize, Qt
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDropEvent,
    QGuiApplication,
    QKeyEvent,
    QResizeEvent,
)
from PySide6.QtWidgets import QApplication, QDockWidget, QMainWindow, QWidget

from tactile_widgets.actions.focused_keys import FocusedKeys
from tactile_widgets.actions.registry import ActionRegistry, build_menus
from tactile_widgets.actions.table import REMEDIES, menu_bar
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import column_layout
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.number_field import guard_wheel
from tactile_widgets.common.settings import Settings
from tactile_widgets.context.app_context import AppContext, ThemeHolder
from tactile_widgets.context.notification_bar import HintBar, MessageStack
from tactile_widgets.context.notifier import Notifier
from tactile_widgets.dialogs.dialogs import Dialogs
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.recording_notes import RecordingNotes
from tactile_widgets.jobs.later import call_later
from tactile_widgets.panels.model.timing_panel import TimingPanel
from tactile_widgets.panels.panel_column import PanelColumn
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.plots.live_plots import LOWEST, USUAL_HEIGHT, LivePlots
from tactile_widgets.plots.timeline.recording_plots import RecordingPlots
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tactile_widgets.plots.timeline.timeline import Timeline
from tactile_widgets.presenters.composition import Presenters
from tactile_widgets.session.backends import BACKGROUND, INLINE, Backends
from tactile_widgets.session.session_host import SessionHost
from tactile_widgets.views.colour_bar import ColourBar
from tactile_widgets.views.linked_views import LinkedViews
from tactile_widgets.window.drop_overlay import DropOverlay
from tactile_widgets.window.more_views import MoreViews
from tactile_widgets.window.panel_docks import PanelDocks
from tactile_widgets.window.status_line import StatusLine
from tactile_widgets.window.toolbar import SessionToolbar
from tactile_widgets.window.window_commands import WindowCommands

PREFERRED_SIZE = QSize(1400, 900)
"""Preferred size of the window [px]."""
_FRAME = QSize(16, 48)
"""Estimated size of the window frame and title bar, unknown before the window is shown [px]."""
_LOW_WINDOW = 700
"""A window is low under this height [px]."""


class MainWindow(QMainWindow):
    """Main window.

    Args:
        settings: Stored settings.
        backends: Executors of background work; ``INLINE`` in tests and pictures.

    Attributes:
        context: Session, views, panels and services for the presenters, which do not see the window.
        presenters: All presenters.
    """

    def __init__(self, settings: Settings, *, backends: Backends = BACKGROUND) -> None:
        super().__init__()
        self.settings = settings
        self._backends = backends
        self._theme = ThemeHolder(settings, self)
        self.live = SessionHost(self, backends=backends)
        self.editor = MapEditor(self.live.scene_jobs, self)
        self._build_views()
        self._build_panels()
        self._build_bottom()
        self._build_bars()
        self.context = AppContext(
            session=self.live,
            editor=self.editor,
            notes=RecordingNotes(self),
            views=self.views,
            panels=self.column,
            plots=self.plots,
            recording_plots=self.recording_plots,
            timeline=self.timeline,
            actions=self._actions,
            notifier=self.notifier,
            dialogs=Dialogs(self, settings),
            settings=settings,
            backends=backends,
            theme=self._theme,
        )
        self.presenters = Presenters(self.context, self)
        self.more_views = MoreViews(self.context, self)
        self.panel_docks = PanelDocks(self, self.column, self.more_views, self.context)
        self._commands = WindowCommands(self.context, self, self.panels, self.bottom, self.panel_docks)
        files = self.presenters.files
        lists = {
            "robots": files.list_robots,
            "scenes": files.list_scenes,
            "recent": files.list_recent,
            "findings": self.presenters.studies.list_findings,
            "layouts": self.panel_docks.list_layouts,
            "bodies": self.more_views.list_bodies,
            "coverable": self.presenters.skin.list_coverable,
            "covered": self.presenters.skin.list_covered,
        }
        yielding = [key for spec in self._actions.specs if spec.yields for key in spec.keys]
        FocusedKeys(self, yielding, (ScrubBar, ColourBar), (self.robot_view, self.map_view))
        guard_wheel(self)
        build_menus(self.menuBar(), self._actions, lists)
        self._commands.offer_lists(lists)
        self._connect()
        self._leaving = False
        self.setAcceptDrops(True)
        self.setAnimated(False)
        fit_screen(self)
        if settings.geometry is not None:
            self.restoreGeometry(settings.geometry)
        if settings.layout is not None:
            self.panel_docks.arrange(settings.layout)
        self.views.show_mode(self.live.mode)
        self._update_title()

    # Building.

    def _build_views(self) -> None:
        self.views = LinkedViews(self.theme, PressureScale())
        self.views.set_paced(on=self._backends is not INLINE)  # an inline backend draws only on request
        self.views.robot.display.set_automatic(automatic=self._backends is not INLINE)
        self.robot_view = self.views.robot
        self.map_view = self.views.map
        self.colour_bar = self.views.bar
        self.setCentralWidget(self.views)
        self.notification_bar = MessageStack(self.theme, self.views, clear=self.colour_bar)
        self.drop_overlay = DropOverlay(self.theme, self)
        self.timeline = Timeline(self.theme)
        self._actions = ActionRegistry(self, self.theme, menus=menu_bar(), remedies=REMEDIES)
        self._actions.use_keys(replace(self._actions.keymap, changes=self.settings.keys))

    def _build_bars(self) -> None:
        self.status_line = StatusLine(self)
        self.setStatusBar(self.status_line)
        self.readout = self.status_line.readout
        self.loading_bar = self.status_line.loading
        self.hint_bar = HintBar(self.theme, self.status_line, clear=self.status_line.kept)
        self.hint_bar.hide()
        self.session_bar = SessionToolbar(self._actions, self)
        self.addToolBar(self.session_bar)
        self.notifier = Notifier(self.notification_bar, self.hint_bar, self.status_line, self.loading_bar, self)

    def _build_panels(self) -> None:
        self.column = PanelColumn(self.editor)
        self.column.set_theme(self.theme)
        self.column.follow(self.live, self.views.selection)
        if self.settings.folded is not None:
            self.column.set_folded(self.settings.folded)
        self.column.show_tab(next((tab for tab in PanelTab if tab.value == self.settings.tab), PanelTab.TOUCH))
        self.panels = self._dock("Panels", self.column, Qt.DockWidgetArea.RightDockWidgetArea)

    def _build_bottom(self) -> None:
        self.plots = LivePlots(self.theme, paced=self._backends is not INLINE)
        self.recording_plots = RecordingPlots(self.theme)
        self.plots.follow(self.views.selection)
        self.views.bar.maximum_changed.connect(self._on_scale_changed)
        self.plots.enlarged_changed.connect(self._on_plot_enlarged)
        self._bottom_before: dict[str, int] = {}  # height of the dock before it showed more, by the reason
        self._bottom_next: int | None = None  # height that the dock gets after the layout
        self.recording_plots.lanes_changed.connect(self._on_lanes_changed)
        self.timeline.axis_changed.connect(self.recording_plots.set_axis)
        # Before the presenters, which show the timeline: the dock has its usual height until then.
        self.live.replay.player_changed.connect(self._on_player_changed)
        self.live.recording.changed.connect(self._on_recording_changed)
        content = QWidget()
        column_layout(self.timeline, self.plots, self.recording_plots, parent=content, spacing=0)
        self.bottom = self._dock("Timeline and plots", content, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(f"dock-{title.split()[0].lower()}")
        dock.setTitleBarWidget(QWidget(dock))  # no title: panels have their own headings
        dock.setFeatures(QDockWidget.DockWidgetFeature.NoDockWidgetFeatures)
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        return dock

    def _connect(self) -> None:
        views = self.views
        line = self.status_line
        scene = self.presenters.scene
        self.column.help_requested.connect(self._commands.show_panel_guide)
        self.hint_bar.tour_requested.connect(self._actions["tour"].trigger)
        self.hint_bar.set_navigation(self.views.navigation)
        self.views.navigation_changed.connect(self.hint_bar.set_navigation)
        views.map.readout_changed.connect(self.readout.setText)
        views.selection_described.connect(line.selection.setText)
        views.robot.display.drawn.connect(partial(self.column.get(TimingPanel).add, "3-D view"))
        scene.title_changed.connect(line.show_title)
        scene.factor_changed.connect(line.show_factor)
        scene.rate_changed.connect(line.show_rate)
        self.session_bar.speed_chosen.connect(self.live.set_speed)
        self.presenters.state.changed.connect(self.session_bar.show_state)
        self.column.folded_changed.connect(self._on_folded_changed)
        self.column.tab_changed.connect(self._on_tab_changed)
        for signal in (
            self.presenters.map_files.changed,
            self.live.replay.player_changed,
            self.live.connection.changed,
            self.live.mode_changed,
            scene.title_changed,
        ):
            signal.connect(self._update_title)
        for presenter in (self.presenters.view, self.presenters.skin):
            presenter.panels_requested.connect(self._commands.show_panels)
        for part in (
            views,
            self.column,
            self.timeline,
            self.plots,
            self.recording_plots,
            self.notification_bar,
            self.hint_bar,
            self.drop_overlay,
            self._actions,
        ):
            self._theme.changed.connect(part.set_theme)

    def _update_title(self) -> None:
        """Show document, robot and mode in the title; mark unsaved changes unless a recording is shown."""
        files = self.presenters.map_files
        player = self.live.replay.player
        prepared = self.live.prepared
        name = f"{files.name}[*]" if player is None else player.path.name
        words = [] if prepared is None else [name, prepared.robot.name, self._mode_word]
        self.setWindowTitle(" – ".join([*words, "Tactile Maps"]) if words else "Tactile Maps[*]")
        self.setWindowModified(bool(files.unsaved) and player is None)

    @property
    def _mode_word(self) -> str:
        live = self.live.live_input is not None and self.live.mode is Mode.RUNNING
        return "live" if live else self.live.mode.name.lower()

    def _on_folded_changed(self, names: tuple[str, ...]) -> None:
        self.settings.folded = names

    def _on_tab_changed(self, tab: PanelTab) -> None:
        if tab is not PanelTab.LIVE:
            self.settings.tab = tab.value

    @property
    def theme(self) -> Theme:
        """Current theme."""
        return self._theme.theme

    def set_theme(self, name: str) -> None:
        """Apply the theme ``dark`` or ``light``."""
        self._theme.use(name)

    def action(self, name: str) -> QAction:
        """Return the action with a name."""
        return self._actions[name]

    def show_quality(self) -> None:
        """Measure the map now, if the backends are inline; otherwise that happens in the background."""
        self.live.measurements.map_executor.run_waiting()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept files, and show what dropping them will do."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()
            self.drop_overlay.show_text(self.presenters.files.drop_text(_files(event)))

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        """Hide what dropping would do."""
        self.drop_overlay.hide()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the first dropped file, or several files of taxels."""
        self.drop_overlay.hide()
        self.presenters.files.open_paths(_files(event))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Reduce the plots in a low window, so that the views keep their space."""
        super().resizeEvent(event)
        self._resize_plots()

    def _resize_plots(self) -> None:
        self.plots.setMinimumHeight(self.plots.preferred_height(self.height(), low=self.height() < _LOW_WINDOW))
        usual = USUAL_HEIGHT if self.height() >= _LOW_WINDOW else LOWEST
        self.recording_plots.setMinimumHeight(self.recording_plots.preferred_height(usual))

    def _on_plot_enlarged(self, enlarged: bool) -> None:
        self._grow_bottom("plot", grown=enlarged)

    def _on_scale_changed(self, _maximum: float) -> None:
        for plots in (self.plots, self.recording_plots):
            plots.set_scale(self.views.scale)

    def _on_lanes_changed(self) -> None:
        self._resize_plots()
        plots = self.recording_plots
        if not plots.added and not plots.raster_shown and "replay" in self._bottom_before:
            self._resize_bottom(self._bottom_before["replay"])

    def _on_player_changed(self, player: object) -> None:
        self._grow_bottom("replay", grown=player is not None)

    def _on_recording_changed(self, path: str | None) -> None:
        self._grow_bottom("recording", grown=path is not None)

    def _grow_bottom(self, reason: str, *, grown: bool) -> None:
        """Give the dock below the views the height that its content needs, or the height before it needed more.

        A reason that began later keeps the dock high, and ends with the height before the one that ended now.
        """
        before = self._bottom_before
        if grown and reason not in before:
            before[reason] = self.bottom.height() if self._bottom_next is None else self._bottom_next
        self._resize_plots()
        if grown or reason not in before:
            return
        later = next(iter([*before][[*before].index(reason) + 1 :]), None)
        height = before.pop(reason)
        if later is None:
            self._resize_bottom(height)
        else:
            before[later] = height

    def _resize_bottom(self, height: int) -> None:
        self._bottom_next = height

        def resize() -> None:
            self._bottom_next = None
            self._resize_bottom_now(height)

        call_later(self, resize)  # after the parts are hidden

    def _resize_bottom_now(self, height: int) -> None:
        for part in (self.bottom.widget(), self.bottom, self):  # they may need the height of a part hidden now
            QCoreApplication.sendPostedEvents(part, QEvent.Type.LayoutRequest.value)
        self.resizeDocks([self.bottom], [height], Qt.Orientation.Vertical)

    def _shrink_bottom(self) -> None:
        """Remove what a recording or replay shows below the views, so that it is not part of the stored layout."""
        heights = [*self._bottom_before.values()]
        if heights:
            self.timeline.hide()
            self.recording_plots.hide()
            self._resize_bottom_now(heights[0])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Handle keys that no widget used; the right arrow advances one tick."""
        if event.key() == Qt.Key.Key_Right and not event.modifiers():
            self.action("step").trigger()
        else:
            super().keyPressEvent(event)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about unsaved edits, complete the recording, end threads and processes, and release the graphics.

        The focused field loses the focus first. Otherwise the field of an undocked panel would emit its value when its
        window is destroyed, after the receivers of the value.
        """
        if (focused := QApplication.focusWidget()) is not None:
            focused.clearFocus()
        if self.presenters.map_files.unsaved and not self._leaving:
            event.ignore()
            self.presenters.map_files.leave(self._close_for_good)
            return
        self.settings.geometry = self.saveGeometry()
        self._shrink_bottom()
        self.settings.layout = self.panel_docks.layout
        self.presenters.close()
        self.context.dialogs.remember_saved()
        self.live.close()
        self.more_views.close()
        self.robot_view.close_view()
        super().closeEvent(event)

    def _close_for_good(self) -> None:
        self._leaving = True
        self.close()

    def createPopupMenu(self) -> None:
        """Open no menu: it would hide bars by accident; the menu View shows and hides them."""


def _files(event: QDropEvent) -> list[str]:
    """Return the paths of dragged files."""
    return [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]


def first_rectangle(room: QRect) -> QRect:
    """Return the first geometry of the window without its frame.

    Args:
        room: Available part of the screen [logical px].

    Returns:
        The preferred size, or as much of it as fits with a frame, in the middle of ``room``.
    """
    size = PREFERRED_SIZE.boundedTo(room.size() - _FRAME)
    place = QRect(room.topLeft(), size)
    place.moveCenter(room.center())
    place.moveTop(max(place.top(), room.top() + _FRAME.height() - _FRAME.width() // 2))
    return place


def fit_screen(window: QMainWindow) -> None:
    """Set the initial size and position of the window; the preferred size if there is no screen."""
    screen = window.screen() or QGuiApplication.primaryScreen()
    if screen is None or QGuiApplication.platformName() == "offscreen":
        window.resize(PREFERRED_SIZE)
    else:
        window.setGeometry(first_rectangle(screen.availableGeometry()))

"""The window: views, panels, menus and what connects them. Wiring only; it decides nothing about touch."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import QApplication, QDockWidget, QLabel, QMainWindow, QVBoxLayout, QWidget

from app.recording.player import RecordingPlayer
from app.session.frame import Frame
from app.session.prepare import PreparedScene
from widgets.actions.registry import make_actions
from widgets.common.colours import THEMES, PressureScale, apply_theme
from widgets.common.notification_bar import HintBar, NotificationBar
from widgets.common.settings import Settings
from widgets.document.map_editor import MapEditor
from widgets.panels.panel_column import PanelColumn
from widgets.plots.live_plots import LivePlots
from widgets.presenters.control_presenter import ControlPresenter, ControlToolsPresenter
from widgets.presenters.effects_presenter import EffectsPresenter
from widgets.presenters.file_presenter import FilePresenter, SceneFilePresenter
from widgets.presenters.linked_views import LinkedViews
from widgets.presenters.map_edit_presenter import MapEditPresenter
from widgets.presenters.notification_presenter import NotificationPresenter
from widgets.presenters.touch_script_presenter import TouchScriptPresenter
from widgets.presenters.view_presenter import ViewPresenter
from widgets.session.backends import BACKGROUND, Backends
from widgets.session.live_session import LiveSession
from widgets.timeline.timeline import Timeline
from widgets.window.toolbar import SessionToolbar
from widgets.workers.map_quality_worker import InlineMapQualityWorker


class MainWindow(QMainWindow):
    """The whole window.

    Args:
        settings: What it remembers.
        backends: What does the work; ``INLINE`` in tests and pictures.
    """

    def __init__(self, settings: Settings, *, backends: Backends = BACKGROUND) -> None:
        super().__init__()
        self.settings = settings
        self.theme = THEMES[settings.theme]
        self.live = LiveSession(self, backends=backends)
        self.editor = MapEditor(self.live.worker, self)
        self.actions_by_name = make_actions(self)
        self._build_views()
        self._build_panels()
        self._build_bottom()
        self._build_status()
        self.effects_presenter = EffectsPresenter(self)
        self.scene_file_presenter = SceneFilePresenter(self)
        self.view_presenter = ViewPresenter(self)
        self.file_presenter = FilePresenter(self)
        self.session_bar = SessionToolbar(self.actions_by_name, self.theme, self)
        self.addToolBar(self.session_bar)
        self.loading_bar = self.session_bar.loading
        self.notification_presenter = NotificationPresenter(self)
        self.touch_script_presenter = TouchScriptPresenter(self)
        self._connect()
        self.control_tools_presenter = ControlToolsPresenter(self)
        self.control_presenter = ControlPresenter(self, backends.comparison_worker)
        self.map_edit_presenter = MapEditPresenter(
            self
        )  # after the views, which show another scene before its map is edited
        self._leaving = False
        self.setAcceptDrops(True)
        self.setAnimated(False)
        self.resize(1400, 900)
        if settings.geometry is not None:
            self.restoreGeometry(settings.geometry)
        self._on_mode_changed("empty")

    # Building.

    def _build_views(self) -> None:
        self.views = LinkedViews(self.theme, PressureScale())
        self.robot_view, self.map_view, self.colour_bar = self.views.robot, self.views.map, self.views.bar
        self.setCentralWidget(self.views)
        self.hint_bar, self.notification_bar = HintBar(self.theme, self.views), NotificationBar(self.theme, self.views)
        self.hint_bar.hide()

    def _build_status(self) -> None:
        """Made at once: made by its first message, the bar would move the views."""
        self.statusBar().setSizeGripEnabled(False)
        self.readout = QLabel()
        self.readout.setObjectName("readout")
        self.readout.setContentsMargins(12, 0, 12, 0)
        self.statusBar().addPermanentWidget(self.readout)

    def _build_panels(self) -> None:
        self.column = PanelColumn(self.editor)
        self.column.accuracy.set_theme(self.theme)
        if self.settings.folded is not None:
            self.column.set_folded(self.settings.folded)
        self.column.folded_changed.connect(self._on_folded_changed)
        self.panels = self._dock("Panels", self.column, Qt.DockWidgetArea.RightDockWidgetArea)

    def _build_bottom(self) -> None:
        self.timeline, self.plots = Timeline(self.theme), LivePlots(self.theme)
        content = QWidget()
        column = QVBoxLayout(content)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.timeline)
        self.plots.setFixedHeight(140)
        column.addWidget(self.plots)
        self.bottom = self._dock("Timeline and plots", content, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea)

    def _dock(self, title: str, content: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(f"dock-{title.split()[0].lower()}")
        dock.setTitleBarWidget(QWidget(dock))  # a plain edge: panels have headings of their own
        dock.setFeatures(QDockWidget.DockWidgetFeature.NoDockWidgetFeatures)
        dock.setWidget(content)
        self.addDockWidget(area, dock)
        return dock

    def _update_toolbar(self) -> None:
        mode = self.live.mode
        playing = mode == "live" or (mode == "replaying" and self.timeline.playhead.playing)
        self.session_bar.show_state(mode, playing=playing, recording=self.live.recorder is not None)

    def _connect(self) -> None:
        live, views = self.live, self.views
        views.poke_pressed.connect(live.press)
        views.poke_moved.connect(live.move)
        views.poke_released.connect(live.release)
        views.open_requested.connect(self.action("open_robot").trigger)
        views.cancel_requested.connect(live.cancel_loading)
        views.read_out.connect(self.readout.setText)
        self.loading_bar.cancelled.connect(live.cancel_loading)
        live.prepared_changed.connect(self._on_prepared_changed)
        live.frame_ready.connect(self._on_frame_ready)
        live.loading.connect(self._on_loading)
        live.loading_ended.connect(self._on_loading_ended)
        live.mode_changed.connect(self._on_mode_changed)
        live.recording_changed.connect(self._on_recording_changed)
        live.player_changed.connect(self._on_player_changed)
        live.settings_changed.connect(self._on_settings_changed)
        live.touched.connect(self._on_hints_read)
        self.hint_bar.dismissed.connect(self._on_hints_read)
        self.column.follow(live, views.selection)
        self.plots.follow(views.selection)
        self.timeline.scrubbed.connect(live.show_time)
        self.timeline.play_toggled.connect(self._on_play_toggled)
        self.timeline.live_requested.connect(live.back_to_live)
        self.session_bar.speed_chosen.connect(live.set_speed)
        self.robot_view.drawn.connect(self._on_drawn)

    # Facts.

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        self.views.show_prepared(prepared)
        self.column.show_prepared(prepared)
        self.plots.clear()
        self.hint_bar.setVisible(not self.settings.hints_read)
        self.session_bar.show_title(prepared.scene.title or prepared.robot.name)
        if prepared.robot.findings or prepared.skin.findings:
            count = len(prepared.robot.findings) + len(prepared.skin.findings)
            self.statusBar().showMessage(
                f"{count} import warnings; see tactile-maps inspect {prepared.scene.robot}",
                10_000,
            )

    def _on_frame_ready(self, frame: Frame) -> None:
        self.views.show_frame(frame)
        runner = self.live.runner
        factor = None if self.live.player or not runner else runner.real_time_factor
        self.session_bar.show_factor(factor)
        self.column.timing.show_factor(factor)
        self.column.show_frame(frame)
        self.plots.show_frame(frame)
        if (recorder := self.live.recorder) is not None:
            self.timeline.set_live(recorder.frames * recorder.tick)

    def _on_loading(self, text: str, fraction: float) -> None:
        """The first robot's progress fills the views; another's stays beside the one that lives."""
        if self.live.prepared is None:
            self.views.show_loading(text, fraction)
        else:
            self.loading_bar.show_progress(text, fraction)

    def _on_loading_ended(self) -> None:
        self.loading_bar.clear()
        self.views.show_last()

    def _on_mode_changed(self, mode: str) -> None:
        self.views.show_mode(mode)
        self._update_toolbar()

    def _on_recording_changed(self, path: str | None) -> None:
        self.timeline.set_live(0.0 if path is not None else None)
        self._update_toolbar()

    def _on_player_changed(self, player: RecordingPlayer | None) -> None:
        if player is None:
            self.timeline.set_live(None)
        else:
            tick = player.prepared.scene.tick
            spans, edits = player.poke_spans(), player.edits()
            self.timeline.set_recording(player.duration, spans, edits=edits, frame_seconds=tick)
            self.live.map_quality_worker.measure(player.prepared.map)

    def _on_settings_changed(self, settings: object) -> None:
        self.plots.show_settings(settings)  # type: ignore[arg-type]

    def _on_folded_changed(self, names: tuple[str, ...]) -> None:
        self.settings.folded = names

    def _on_hints_read(self) -> None:
        self.hint_bar.hide()
        self.settings.hints_read = True

    def _on_play_toggled(self, _playing: bool) -> None:
        self._update_toolbar()

    def _on_drawn(self, milliseconds: float) -> None:
        self.column.timing.add("3-D view", milliseconds)

    def set_theme(self, name: str) -> None:
        """Dress everything in ``dark`` or ``light``."""
        self.theme = THEMES[name]
        self.settings.theme = name
        apply_theme(QApplication.instance(), self.theme)  # type: ignore[arg-type]
        for part in (
            self.views,
            self.timeline,
            self.plots,
            self.notification_bar,
            self.hint_bar,
            self.session_bar,
            self.column.accuracy,
            self.control_presenter,
        ):
            part.set_theme(self.theme)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Qt: files are welcome."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Qt: open the first file dropped."""
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        if paths:
            self.file_presenter.open_path(paths[0])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: what no widget wanted; Right steps, where it neither pans the map nor turns a gain."""
        if event.key() == Qt.Key.Key_Right and not event.modifiers():
            self.action("step").trigger()
        else:
            super().keyPressEvent(event)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Qt: ask about unsaved edits, complete the recording, end thread and processes, give the graphics back."""
        if self.map_edit_presenter.files.unsaved and not self._leaving:
            event.ignore()
            self.map_edit_presenter.files.leave(self._close_for_good)
            return
        self.settings.geometry = self.saveGeometry()
        self.map_edit_presenter.files.close()
        self.column.accuracy.shut()
        self.control_presenter.close()
        self.file_presenter.close()
        self.live.close()
        self.robot_view.close_view()
        super().closeEvent(event)

    def _close_for_good(self) -> None:
        self._leaving = True
        self.close()

    def createPopupMenu(self) -> None:
        """Qt: no menu for hiding bars by accident; View has it."""

    def action(self, name: str) -> QAction:
        """The action called ``name``."""
        return self.actions_by_name[name]

    def show_quality(self) -> None:
        """Measure the map that is shown, here and now; of the backends beside the window it comes by itself."""
        if isinstance(self.live.map_quality_worker, InlineMapQualityWorker):
            self.live.map_quality_worker.run()

"""Distribution of scenes and tick results of the session to views, panels and plots, in a defined order."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import counted
from tactile_maps.core.plugins import Plugin, broken_plugins
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame
from tactile_maps.session.link_levels import MANY_FACES, faces_of_links, links_digest
from tactile_maps.session.prepare import PreparedScene, findings_of
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import JobProgress, Presenter
from tactile_widgets.panels.model.timing_panel import TimingPanel
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.presenters.maps.map_edit_presenter import MapEditPresenter
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter

_FINDINGS_MS = 10_000


class ScenePresenter(Presenter):
    """Passes scenes and tick results to everything that shows them.

    Args:
        context: Session, views, panels and services of the window.
        effects: Simulated effects.
        map_edit: Editor of the map of the scene.
        parent: Window over which dialogs open.
    """

    title_changed = Signal(str)
    """Title of the scene that is shown now."""
    factor_changed = Signal(object)
    """Real-time factor reached; None in a replay."""
    rate_changed = Signal(float)
    """Rate of the readings of a real skin [Hz]."""

    def __init__(
        self, context: AppContext, effects: EffectsPresenter, map_edit: MapEditPresenter, parent: QWidget
    ) -> None:
        super().__init__(context, parent)
        self._effects = effects
        self._map_edit = map_edit
        self._reported_plugins: set[Plugin] = set()
        session = context.session
        views = context.views
        session.prepared_changed.connect(self._on_prepared_changed)
        session.scene_jobs.image_made.connect(views.map.keep_image)
        session.scene_jobs.levels_made.connect(views.robot.display.set_link_levels)
        session.frames_passed.connect(context.plots.keep)
        session.frame_ready.connect(self._on_frame_ready)
        context.panels.get(LiveInputPanel).rate_changed.connect(self._on_rate_changed)
        session.loading.connect(self._on_loading)
        session.loading_ended.connect(self._on_loading_ended)
        session.mode_changed.connect(views.show_mode)
        session.settings_changed.connect(context.plots.show_settings)
        session.settings_changed.connect(views.show_settings)
        for card in (views.robot.card, views.map.card):
            card.open_requested.connect(context.actions["open_robot"].trigger)
            card.cancel_requested.connect(session.cancel_loading)
        self._progress = JobProgress(self._notifier, session.cancel_loading)

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        """Show another scene: first the effects, then the views and panels, and last its map for editing."""
        context = self._context
        self._effects.show_prepared(prepared)
        context.views.show_prepared(prepared)
        context.panels.show_prepared(prepared)
        context.plots.show_prepared(prepared)
        self._map_edit.show_prepared(prepared)
        context.views.map.frame_all()  # after the edits that the map keeps, which may need more space
        self.title_changed.emit(prepared.scene.title or prepared.robot.name)
        if prepared.robot.findings or prepared.skin.findings or prepared.findings:
            count = len(findings_of(prepared))
            context.notifier.status(f"{counted(count, 'finding')}; see the panel Findings", _FINDINGS_MS)
        elif not self._session.simulating:
            context.notifier.status("")  # the introduction of a scene suggests what a recording or real skin cannot do
        elif prepared.scene.description:
            context.notifier.introduce(prepared.scene.description, prepared.scene.suggestion)
        self._report_plugins()
        self._make_links_coarser(prepared.robot)

    def _make_links_coarser(self, robot: Robot) -> None:
        """Request coarser meshes of links with very many triangles, if the views use them."""
        display = self._context.views.robot.display
        known = display.actors.link_levels
        if not display.takes_levels or faces_of_links(robot) < MANY_FACES:
            return
        if known is None or known.digest != links_digest(robot):
            self._session.scene_jobs.make_levels(robot)

    def _report_plugins(self) -> None:
        """Report plug-ins that could not be loaded, each once."""
        new = [plugin for plugin in broken_plugins() if plugin not in self._reported_plugins]
        self._reported_plugins.update(new)
        if new:
            found = new[0].finding
            more = f" {len(new) - 1} more: see tactile-maps inspect --plugins." if len(new) > 1 else ""
            self._notifier.fault(f"Plug-in {found.where}: {found.action}.{more}", of="open file")

    def _on_frame_ready(self, frame: Frame) -> None:
        context = self._context
        runner = self._session.runner
        context.views.show_frame(frame)
        simulated = self._session.live_input is None
        factor = None if self._session.replay.player or not runner or not simulated else runner.real_time_factor
        if simulated or self._session.replay.player:
            self.factor_changed.emit(factor)
        context.panels.get(TimingPanel).show_factor(factor)
        context.panels.show_frame(frame)
        context.plots.show_frame(frame)
        if (recorder := self._session.recording.recorder) is not None:
            context.timeline.set_live(recorder.seconds, marks=self._session.recording.marks)

    def _on_rate_changed(self, rate: float) -> None:
        if self._session.replay.player is None:
            self.rate_changed.emit(rate)

    def _on_loading(self, text: str, fraction: float) -> None:
        """Show the progress: of the first robot in the views, of another one in the status line."""
        if self._session.prepared is None:
            self._context.views.show_loading(text, fraction)
        else:
            self._progress.show(text, fraction)

    def _on_loading_ended(self) -> None:
        self._progress.end()
        self._context.views.show_last()

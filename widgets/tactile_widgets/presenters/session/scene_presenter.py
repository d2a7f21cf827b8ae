"""Shows what the session prepared and computes: the one receiver of scenes and frames, so that their order is written
down.
"""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.plugins import Plugin, broken_plugins
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.frame import Frame
from tactile_maps.session.link_levels import MANY_FACES, faces_of_links, links_digest
from tactile_maps.session.prepare import PreparedScene, findings_of
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.panels.model.timing_panel import TimingPanel
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.presenters.maps.map_edit_presenter import MapEditPresenter
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter

SCENE_JOB = "scene"
"""Key of the progress of a scene that is being prepared."""
_FINDINGS_MS = 10_000


class ScenePresenter(QObject):
    """Hands scenes and frames to everything that shows them.

    Args:
        context: What it works on.
        effects: What is simulated.
        map_edit: The scene's map as a document.
        parent: Qt parent.
    """

    title_changed = Signal(str)
    """Another scene is shown: its name for people."""
    factor_changed = Signal(object)
    """Simulated seconds per second reached; None in a replay."""
    rate_changed = Signal(float)
    """Readings of a real skin a second, while it is shown [Hz]."""

    def __init__(
        self, context: AppContext, effects: EffectsPresenter, map_edit: MapEditPresenter, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._context = context
        self._session = context.session
        self._effects = effects
        self._map_edit = map_edit
        self._plugins_told: set[Plugin] = set()
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
        context.notifier.cancelled.connect(self._on_cancelled)

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        """Another scene: first what it is, then the views, then the panels, then its map, which the views then edit."""
        context = self._context
        self._effects.show_prepared(prepared)
        context.views.show_prepared(prepared)
        context.panels.show_prepared(prepared)
        context.plots.show_prepared(prepared)
        self._map_edit.show_prepared(prepared)
        context.views.map.frame_all()  # with the edits that the map continues with, which may take more room
        self.title_changed.emit(prepared.scene.title or prepared.robot.name)
        if prepared.robot.findings or prepared.skin.findings or prepared.findings:
            count = len(findings_of(prepared))
            context.notifier.status(f"{count} finding{'s' * (count > 1)}; see the panel Findings", _FINDINGS_MS)
        elif prepared.scene.description:
            context.notifier.introduce(prepared.scene.description, prepared.scene.suggestion)
        self._tell_of_plugins()
        self._make_links_coarser(prepared.robot)

    def _make_links_coarser(self, robot: Robot) -> None:
        """Ask for what the views draw faster than links of very many triangles, where that is worth it."""
        display = self._context.views.robot.display
        known = display.actors.link_levels
        if not display.takes_levels or faces_of_links(robot) < MANY_FACES:
            return
        if known is None or known.digest != links_digest(robot):
            self._session.scene_jobs.make_levels(robot)

    def _tell_of_plugins(self) -> None:
        """Plug-ins that were left out, each once."""
        new = [plugin for plugin in broken_plugins() if plugin not in self._plugins_told]
        self._plugins_told.update(new)
        if new:
            found = new[0].finding
            more = f" {len(new) - 1} more: see tactile-maps inspect --plugins." if len(new) > 1 else ""
            self._context.notifier.fault(f"Plug-in {found.where}: {found.action}.{more}")

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
            context.timeline.set_live(recorder.frames * recorder.tick, marks=self._session.recording.marks)

    def _on_rate_changed(self, rate: float) -> None:
        if self._session.replay.player is None:
            self.rate_changed.emit(rate)

    def _on_loading(self, text: str, fraction: float) -> None:
        """The first robot's progress fills the views; another's stays beside the one that lives."""
        if self._session.prepared is None:
            self._context.views.show_loading(text, fraction)
        else:
            self._context.notifier.progress(SCENE_JOB, text, fraction)

    def _on_loading_ended(self) -> None:
        self._context.notifier.done(SCENE_JOB)
        self._context.views.show_last()

    def _on_cancelled(self, job: str) -> None:
        if job == SCENE_JOB:
            self._session.cancel_loading()

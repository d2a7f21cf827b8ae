"""State of the window for the actions, read whenever it may have changed."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.control.motion.command import ControlSettings
from tactile_widgets.actions.state import UndoState, WindowState
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.panels.control.controller_panel import can_restart_task
from tactile_widgets.presenters.files.unsaved_presenter import UnsavedPresenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.presenters.session.overlay_presenter import OverlayPresenter
from tactile_widgets.tools.registry import Tools


class StateTracker(Presenter):
    """Reads the state of the window when it may have changed, but not at ticks, and applies it to the actions.

    Args:
        context: Session, views, panels and services of the window.
        tools: Tools of the views.
        overlay: Second recording.
        map_files: File of the map.
        parent: Qt parent.

    Attributes:
        state: State that was read last.
    """

    changed = Signal(WindowState)
    """Current state, after a change."""

    def __init__(
        self,
        context: AppContext,
        tools: Tools,
        overlay: OverlayPresenter,
        map_files: MapFilePresenter,
        unsaved: UnsavedPresenter,
        parent: QWidget,
    ) -> None:
        super().__init__(context, parent)
        self._tools = tools
        self._settings = ControlSettings()
        self._overlay = overlay
        self._map_files = map_files
        self._unsaved = unsaved
        self.state = WindowState()
        session = context.session
        editor = context.editor
        session.settings_changed.connect(self._on_settings_changed)
        for signal in (
            session.mode_changed,
            session.recording.changed,
            session.sharing.changed,
            session.recording.for_viewers_changed,
            session.prepared_changed,
            session.connection.changed,
            context.timeline.play_toggled,
            context.timeline.range_changed,
            context.timeline.loop_changed,
            context.notes.changed,
            overlay.changed,
            map_files.changed,
            unsaved.changed,
            editor.history_changed,
            editor.selection_changed,
            editor.enabled_changed,
            editor.working,
            editor.rested,
            editor.proposal_changed,
            tools.changed,
            tools.undo_changed,
            context.views.overlays_changed,
            context.views.robot.hidden_changed,
            context.theme.changed,
        ):
            signal.connect(self.update)
        self.update()

    def update(self, *_changed: object) -> None:
        """Read the state and apply it if it has changed. Cost without a change: 20 µs."""
        state = self._read()
        if state != self.state:
            self.state = state
            self._context.actions.show(state)
            self.changed.emit(state)

    def _on_settings_changed(self, settings: ControlSettings) -> None:
        self._settings = settings
        self.update()

    def _read(self) -> WindowState:
        context = self._context
        control = self._tools.control
        stack = self._tools.undo_stack
        session = context.session
        editor = context.editor
        settings = self._settings
        mode = session.mode
        scene = None if session.prepared is None else session.prepared.scene
        return WindowState(
            mode=mode,
            playing=mode is Mode.RUNNING or (mode is Mode.REPLAYING and context.timeline.playhead.playing),
            recording=session.recording.recorder is not None,
            shared_with="" if session.sharing.kind is None else session.sharing.kind.value,
            recorded_for_viewers=session.recording.for_viewers,
            controller=settings.controller,
            task=settings.task,
            path_kind=settings.path_kind,
            can_control=control.enabled and control.map is not None,
            can_pose=self._tools.posture.enabled,
            can_undo_posture=self._tools.posture.can_undo,
            has_path=bool(settings.path),
            can_restart_task=can_restart_task(settings),
            editable=editor.enabled and editor.document is not None,
            restorable=self._map_files.restorable,
            unsaved_elsewhere=self._unsaved.found,
            edit_busy=editor.busy,
            patches_selected=bool(editor.selected),
            tool=self._tools.active,
            undo=UndoState(stack.can_undo, stack.can_redo, stack.undo_step.name, stack.redo_step.name),
            overlays=context.views.overlays,
            bodies_hidden=bool(context.views.robot.display.actors.hidden),
            light=context.theme.theme.name == "light",
            measured=session.live_input is not None,
            measured_recording=session.replay.player is not None and session.replay.player.measured is not None,
            notable=context.notes.editable,
            has_marks=bool(context.notes.value.marks),
            has_episodes=bool(context.notes.value.episodes),
            overlaid=self._overlay.other is not None,
            can_repeat=session.replay.player is not None and session.simulates_behind,
            has_range=context.timeline.range is not None,
            looping=context.timeline.playhead.loop is not None,
            has_script=scene is not None and bool(scene.stimuli),
            script_repeats=scene is None or scene.repeat_stimuli,
        )

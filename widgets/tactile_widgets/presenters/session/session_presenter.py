"""The Session menu and what keeps a session: time, recordings, replay, reports of a stop."""

from __future__ import annotations

from datetime import datetime
from functools import partial
from itertools import chain, count
from pathlib import Path

from platformdirs import user_documents_path
from PySide6.QtCore import QElapsedTimer, QObject, QTimer
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.recording.file.damage import damage_text
from tactile_maps.recording.player import RecordingPlayer
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.dialogs.connect_dialog import ConnectDialog
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.plots.timeline.scrub_bar import DamagedSpan
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.session.recording_writer import make_recording_folder

_PLAY_MS = 16
_MOST_TOLD = 3
"""Kinds of damage that a message names; *inspect* lists all."""


class SessionPresenter(QObject):
    """Starts, stops and records what runs, and plays what was recorded.

    Args:
        context: What it works on.
        parent: Qt parent.
    """

    def __init__(self, context: AppContext, parent: QObject) -> None:
        super().__init__(parent)
        self._context = context
        self._session = context.session
        self._timeline = context.timeline
        self._play_clock = QElapsedTimer()
        self._play_timer = QTimer(self)
        self._play_timer.setInterval(_PLAY_MS)
        self._play_timer.timeout.connect(self._on_play_timer)
        for name, handler in (
            ("pause", self.toggle_pause),
            ("step", self._session.step),
            ("reset", self._session.reset),
            ("record", self.toggle_record),
            ("save_report", self.save_report),
        ):
            context.actions.bind(name, handler)
        for gestures in context.views.interactions:
            gestures.space_tapped.connect(partial(context.actions.trigger_key, "Space"))
        self._timeline.play_toggled.connect(self._on_play_toggled)
        self._timeline.scrubbed.connect(self._session.replay.seek)
        self._timeline.live_requested.connect(self._session.replay.leave)
        self._session.recording.changed.connect(self._on_recording_changed)
        self._session.replay.player_changed.connect(self._on_player_changed)
        self._session.replay.taken_over.connect(self._on_taken_over)

    def close(self) -> None:
        """Stop what runs by itself."""
        self._play_timer.stop()

    def toggle_pause(self) -> None:
        """Pause or go on; in a replay, play or pause."""
        if self._session.replay.player is not None:
            self._timeline.toggle_play()
        else:
            self._session.set_paused(paused=self._session.mode is Mode.RUNNING)

    def toggle_record(self) -> None:
        """Start recording to a new file, or complete the one being written."""
        if self._session.recording.recorder is not None:
            self._session.recording.stop()
            return
        folder = recordings_folder()
        try:
            make_recording_folder(folder)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
        else:
            prepared = self._session.prepared
            name = prepared.robot.name if prepared is not None else "session"
            self._session.recording.start(free_name(folder / f"{name} {datetime.now():%Y-%m-%d %H.%M.%S}.mcap"))

    def save_report(self) -> None:
        """Keep what led to the stop where recordings are kept."""
        self._session.recording.save_report(
            free_name(recordings_folder() / f"stopped {datetime.now():%Y-%m-%d %H.%M.%S}.mcap")
        )

    def _on_recording_changed(self, path: str | None) -> None:
        self._timeline.set_live(0.0 if path is not None else None)

    def _on_player_changed(self, player: RecordingPlayer | None) -> None:
        if player is None:
            self._timeline.set_live(None)
        else:
            tick = player.prepared.scene.tick
            spans = player.poke_spans()
            edits = player.edits()
            damage = [DamagedSpan(start, end, damage_text(one, tick)) for start, end, one in player.damaged_spans()]
            self._timeline.set_recording(player.duration, spans, edits=edits, damage=damage, frame_seconds=tick)
            if player.damage:
                self._context.notifier.fault(_damage_message(player))
            self._session.measurements.measure(player.prepared.map)

    def _on_taken_over(self, seconds: float, same: bool) -> None:
        words = f"Taken over at {seconds:.2f}\u202fs"
        if same:
            self._context.notifier.status(f"{words}, in the recorded state bit for bit")
        else:
            self._context.notifier.say(
                f"{words}. Posture and speed differ from the recorded ones: it was recorded by other versions of the "
                "program or its libraries."
            )

    def _on_play_toggled(self, playing: bool) -> None:
        if playing:
            self._play_clock.start()
            self._play_timer.start()
        else:
            self._play_timer.stop()

    def _on_play_timer(self) -> None:
        self._timeline.advance(1e-3 * self._play_clock.restart())


def _damage_message(player: RecordingPlayer) -> str:
    """What a recording has lost: the first things in words, the others counted."""
    tick = player.prepared.scene.tick
    told = [damage_text(one, tick) for one in player.damage]
    more = f"; and {len(told) - _MOST_TOLD} more" if len(told) > _MOST_TOLD else ""
    return f"{player.path.name} is damaged: {'; '.join(told[:_MOST_TOLD])}{more}. The timeline marks where."


def free_name(path: Path) -> Path:
    """``path``, or with a number behind it: two windows may record in the same second."""
    names = chain([path], (path.with_stem(f"{path.stem} {number}") for number in count(2)))
    return next(name for name in names if not name.exists())


def recordings_folder() -> Path:
    """Where recordings go by default."""
    return user_documents_path() / "Tactile Maps"


class LiveInputPresenter(QObject):
    """Connects and disconnects.

    Args:
        context: What it works on.
        map_files: Asks about unsaved edits before a recording's map replaces them.
        parent: Qt parent, over which the dialog opens.
    """

    def __init__(self, context: AppContext, map_files: MapFilePresenter, parent: QWidget) -> None:
        super().__init__(parent)
        self._context = context
        self._map_files = map_files
        self._window = parent
        self.dialog: ConnectDialog | None = None
        context.actions.bind("connect", self.ask)
        context.actions.bind("disconnect", context.session.connection.close)
        context.panels.get(LiveInputPanel).disconnect_requested.connect(context.session.connection.close)
        context.session.connection.changed.connect(self._on_live_input_changed)

    def ask(self) -> None:
        """Ask what to connect to; from a recording, first about unsaved edits of the map behind it."""
        if self._context.session.replay.player is None:
            self._open_dialog()
        else:
            self._map_files.leave(self._open_dialog)

    def _open_dialog(self) -> None:
        if self.dialog is None:
            self.dialog = ConnectDialog(self._window)
            self.dialog.connect_requested.connect(self._on_connect_wanted)
        self.dialog.say("")
        self.dialog.open()

    def _on_connect_wanted(self, settings: LiveInputSettings) -> None:
        assert self.dialog is not None
        try:
            self._context.session.connection.open(settings)
        except TactileMapsError as error:
            self.dialog.say(str(error))
        else:
            self.dialog.accept()

    def _on_live_input_changed(self, live: object) -> None:
        if live is not None:
            self._context.panels.reveal(self._context.panels.get(LiveInputPanel))

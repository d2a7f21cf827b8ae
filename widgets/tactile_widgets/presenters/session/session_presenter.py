"""Menu Session: time, recordings, replay, reports of a stop, and connections to a real skin."""

from __future__ import annotations

from datetime import datetime
from functools import partial
from itertools import chain, count
from pathlib import Path

from PySide6.QtCore import QElapsedTimer, QTimer
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import TactileMapsError, names_text
from tactile_maps.live.session.facts import MeasuredFacts, held_text
from tactile_maps.live.session.reading_gap import GapCause, ReadingGap
from tactile_maps.recording.player import RecordingPlayer
from tactile_widgets.common.make import make
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.dialogs.connect_dialog import ConnectDialog
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.panels.touch.requested_motion_panel import RequestedMotionPanel
from tactile_widgets.panels.touch.skin_check_panel import SkinCheckPanel
from tactile_widgets.plots.timeline.playhead import clock_text
from tactile_widgets.plots.timeline.scrub_bar import DamagedSpan
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.session.recording_writer import make_recording_folder

_PLAY_MS = 16
_TARE_AGAIN = "Tare again"
_MOST_NAMED = 3
"""Number of damages that a message names; *inspect* lists all."""


class SessionPresenter(Presenter):
    """Starts, stops and records the session, and plays recordings.

    Args:
        context: Session, views, panels and services of the window.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._timeline = context.timeline
        self._play_clock = QElapsedTimer()
        self._play_timer = make(QTimer, self, interval=_PLAY_MS, timeout=self._on_play_timer)
        context.actions.bind(
            pause=self.toggle_pause,
            step=self._session.step,
            reset=self._session.reset,
            back_to_live=self._session.replay.leave,
            record=self.toggle_record,
            save_report=self.save_report,
        )
        for gestures in context.views.interactions:
            gestures.space_tapped.connect(partial(context.actions.trigger_key, "Space"))
        self._timeline.play_toggled.connect(self._on_play_toggled)
        self._timeline.scrubbed.connect(self._session.replay.seek)
        self._timeline.live_requested.connect(self._session.replay.leave)
        self._session.recording.changed.connect(self._on_recording_changed)
        self._session.replay.player_changed.connect(self._on_player_changed)
        self._session.replay.taken_over.connect(self._on_taken_over)

    def close(self) -> None:
        """Stop playing."""
        self._play_timer.stop()

    def toggle_pause(self) -> None:
        """Pause or resume the session; in a replay, play or pause."""
        if self._session.replay.player is not None:
            self._timeline.toggle_play()
        else:
            self._session.set_paused(paused=self._session.mode is Mode.RUNNING)

    def toggle_record(self) -> None:
        """Start recording to a new file, or complete the one being written."""
        if self._session.recording.recorder is not None:
            self._session.recording.stop()
            return
        folder = self._context.settings.recordings_folder
        try:
            make_recording_folder(folder)
        except TactileMapsError as error:
            self._notifier.fault(str(error), of="record")
        else:
            prepared = self._session.prepared
            name = prepared.robot.name if prepared is not None else "session"
            self._session.recording.start(free_name(folder / f"{name} {datetime.now():%Y-%m-%d %H.%M.%S}.mcap"))
            self._notifier.succeed("record")

    def save_report(self) -> None:
        """Save a recording of the stop in the folder of recordings."""
        folder = self._context.settings.recordings_folder
        self._session.recording.save_report(free_name(folder / f"stopped {datetime.now():%Y-%m-%d %H.%M.%S}.mcap"))

    def _on_recording_changed(self, path: str | None) -> None:
        self._timeline.set_live(0.0 if path is not None else None)

    def _on_player_changed(self, player: RecordingPlayer | None) -> None:
        if player is None:
            self._timeline.set_live(None)
        else:
            spans = player.poke_spans()
            edits = player.edits()
            damage = [DamagedSpan(*span) for span in player.damaged_spans()]
            tick = player.prepared.scene.tick
            self._timeline.set_recording(player.duration, spans, edits=edits, damage=damage, frame_seconds=tick)
            if player.damage:
                self._notifier.fault(_damage_message(player), of="open file")
            self._session.measurements.measure(player.prepared.map)

    def _on_taken_over(self, seconds: float, same: bool) -> None:
        words = f"Taken over at {clock_text(seconds)}"
        if same:
            self._notifier.status(f"{words}; the state equals the recorded one, bit for bit")
        else:
            self._notifier.say(
                f"{words}. Posture and speed differ from the recorded ones: it was made by other versions of the "
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
    """Return a message about the damages of a recording: the first ones in words, and the number of others."""
    damages = names_text(player.damage_texts, _MOST_NAMED, separator="; ")
    return f"The recording {player.path.name} is damaged: {damages}. The timeline marks where."


def free_name(path: Path) -> Path:
    """Return ``path``, with a number if it exists: two windows may record in the same second."""
    names = chain([path], (path.with_stem(f"{path.stem} {number}") for number in count(2)))
    return next(name for name in names if not name.exists())


class LiveInputPresenter(Presenter):
    """Connects to a real skin and disconnects.

    Args:
        context: Session, views, panels and services of the window.
        map_files: Asks about unsaved edits before the map of a recording replaces them.
        parent: Window over which dialogs open.
    """

    def __init__(self, context: AppContext, map_files: MapFilePresenter, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._map_files = map_files
        self.dialog: ConnectDialog | None = None
        self._reported: GapCause | None = None  # cause of a gap in the readings
        self._touched: tuple[tuple[str, ...], ...] | None = None  # taxels of the last tare; None before and during it
        context.actions.bind(connect=self.ask, disconnect=self._session.connection.close, tare_again=self._tare_again)
        panel = context.panels.get(LiveInputPanel)
        panel.disconnect_requested.connect(context.session.connection.close)
        panel.calibration_file_requested.connect(self._choose_calibration_file)
        panel.channels_listed.connect(partial(context.panels.reveal, panel))
        panel.gap_reported.connect(self._on_gap_reported)
        panel.facts_shown.connect(self._on_facts_shown)
        motion = context.panels.get(RequestedMotionPanel)
        motion.stop_reported.connect(self._on_stop_reported)
        motion.start_refused.connect(self._on_start_refused)
        motion.tare_doubted.connect(self._on_tare_doubted)
        context.panels.get(SkinCheckPanel).report_requested.connect(self._choose_report)
        context.session.connection.changed.connect(self._on_live_input_changed)
        context.session.mode_changed.connect(motion.set_mode)

    def ask(self) -> None:
        """Ask for a source; during a replay, first about unsaved edits of the map."""
        if self._session.replay.player is None:
            self._open_dialog()
        else:
            self._map_files.leave(self._open_dialog)

    def _open_dialog(self) -> None:
        if self.dialog is None:
            self.dialog = ConnectDialog(self._context.dialogs, self._window)
            self.dialog.show_source(*self._context.settings.source)
            self.dialog.connect_requested.connect(self._on_connect_requested)
        self.dialog.say("")
        self.dialog.open()

    def _on_connect_requested(self, settings: LiveInputSettings) -> None:
        assert self.dialog is not None
        self._context.settings.source = self.dialog.kind.currentText(), settings.address
        try:
            self._session.connection.open(settings)
        except TactileMapsError as error:
            self.dialog.say(str(error))
        else:
            used = (settings.address, settings.options.mapping, settings.ids, settings.calibration)
            self._context.dialogs.remember_opened(*used)
            self.dialog.accept()

    def _choose_calibration_file(self) -> None:
        """Ask for a file, and write the gains and offsets."""
        panel = self._context.panels.get(LiveInputPanel)
        path = self._context.dialogs.save_file(
            "Save gains and offsets", "gains.csv", "Calibration (*.csv)", over=panel.weight
        )
        if path:
            panel.save_calibration(path)

    def _choose_report(self) -> None:
        """Ask for a file, and write the report of the check."""
        path = self._context.dialogs.save_file("Save the report of the check", "skin check.html", "Web page (*.html)")
        if path:
            self._context.panels.get(SkinCheckPanel).save_report(path)

    def _on_stop_reported(self, reason: str, by_tare: bool) -> None:
        """Report that the motion of the robot is no longer sent, until it is sent again."""
        text = f"Sending to the robot stopped: {reason}"
        if by_tare:
            text = f"{text}. Leave the skin untouched and tare again; then arm and send again."
            again = self._context.actions["tare_again"]
            self._notifier.say(text, fault=True, remedies=[again], of="send motion")
        elif reason:
            self._notifier.fault(text, of="send motion")
        else:
            self._notifier.succeed("send motion")

    def _on_start_refused(self, reason: str) -> None:
        self._notifier.fault(f"Sending to the robot did not start: {reason}", of="send motion")

    def _on_tare_doubted(self, reason: str) -> None:
        """Ask whether to arm although the tare is doubtful."""

        def answered(answer: str) -> None:
            if answer == _TARE_AGAIN:
                self._tare_again()
            else:
                self._context.panels.get(RequestedMotionPanel).arm()

        text = f"{reason} The robot may then move against what it does not feel."
        self._context.dialogs.ask_button(
            "doubtful-tare", "Arm after a doubtful tare?", text, ["Arm anyway", _TARE_AGAIN], answered
        )

    def _on_gap_reported(self, gap: ReadingGap | None) -> None:
        """Mark the views as old, and report why no readings are used, once for each cause until readings are used.

        The message states the newest reason while it is shown.
        """
        self._context.views.show_gap("" if gap is None else gap.words)
        if gap is None:
            if self._reported is not None:
                self._notifier.succeed("live readings")
            self._reported = None
        elif gap.reason:
            report = self._notifier.update_fault if gap.cause is self._reported else self._notifier.fault
            self._reported = gap.cause
            report(f"No readings, because {gap.cause}: {gap.reason}", of="live readings")

    def _on_facts_shown(self, facts: MeasuredFacts) -> None:
        """Question a tare during which the skin seems to have been touched, until one follows without a touch."""
        before = self._touched
        done = facts.tared and not facts.taring
        self._touched = (facts.held_in_tare, facts.touched_in_tare) if done else None
        if self._touched is None or self._touched == before:
            return
        texts = []
        if facts.held_in_tare:
            texts.append(held_text(facts.held_in_tare))
        if facts.touched_in_tare:
            names = names_text(facts.touched_in_tare)
            texts.append(f"A part of the tare was left out for {names}, which were touched.")
        if texts:
            texts.append("Leave the skin untouched and tare again.")
            again = self._context.actions["tare_again"]
            self._notifier.say(" ".join(texts), warning=True, remedies=[again], of="tare")
        else:
            self._notifier.succeed("tare")

    def _tare_again(self) -> None:
        if (live := self._session.connection.input) is not None:
            live.tare()
            self._context.panels.get(LiveInputPanel).refresh()

    def _on_live_input_changed(self, live: object) -> None:
        if live is not None:
            self._context.panels.reveal(self._context.panels.get(LiveInputPanel))
        else:
            self._reported = self._touched = None
            self._context.views.show_gap("")

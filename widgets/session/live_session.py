"""The session behind the window: opened, run, recorded, replayed. Requests come in as methods, facts go out as signals.

``RunningSession`` asks the runner for what a person wants (touch, control, effects, an edited map, time) while what it
runs is what is shown; ``LiveSession`` adds opening, recording and replay. It is the only caller that changes the
session.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from app.contacts.pipeline import ReadingSettings
from app.control.behaviours import Behaviour
from app.control.command import ControlChanged, ControlSettings
from app.core.errors import TactileMapsError
from app.geometry.mesh import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.recording.player import RecordingPlayer
from app.recording.recorder import Recorder, save_failure_report
from app.scene.effects import Effects
from app.scene.scene import Scene
from app.session.frame import Frame
from app.session.inputs import BehavioursChanged, EffectsChanged, MapEdited, ReadingChanged, SessionInput
from app.session.prepare import PreparedScene
from app.session.session import Session
from app.stimuli.stimuli_from_pokes import stimuli_from_pokes
from app.stimuli.stimulus import Stimulus
from app.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from widgets.session.active_settings import ActiveSettings
from widgets.session.backends import BACKGROUND, Backends
from widgets.session.recording_writer import RecordingWriter, make_recording_folder
from widgets.session.session_runner import SessionRunner
from widgets.session.session_signals import SessionSignals
from widgets.workers.comparison_worker import ComparisonStimulus

HAND = 1
"""Id of the hand's finger; the scripted ones have 0 and below."""
SCRIPT_SECONDS = 10.0
"""A script is compared on for so long, unless a person says otherwise."""


class RunningSession(SessionSignals):
    """Asks the runner for what a person wants, while what it runs is what is shown.

    Args:
        parent: Qt parent.

    Attributes:
        runner: Of the live session; None before there is one.
        player: Of the recording that is shown instead; None while the live session is.
        finger: That touches.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.runner: SessionRunner | None = None
        self.player: RecordingPlayer | None = None
        self.finger = Finger()
        self._active_settings, self._speed = ActiveSettings(self), 1.0
        self._map: TactileMap | None = None  # in force in the session; the player's may be shown meanwhile
        self._shown_map: TactileMap | None = None

    @property
    def mode(self) -> str:
        """``empty``, ``live``, ``paused`` or ``replaying``."""
        if self.player is not None:
            return "replaying"
        if self.runner is None:
            return "empty"
        return "paused" if self.runner.paused else "live"

    @property
    def _running(self) -> SessionRunner | None:
        """The runner, while what it runs is what is shown."""
        return self.runner if self.player is None else None

    def press(self, at: SurfacePoint) -> None:
        """A finger presses the skin."""
        if self._submit(PokePressed(HAND, at, self.finger)):
            self.touched.emit()

    def move(self, at: SurfacePoint) -> None:
        """It strokes to another place."""
        self._submit(PokeMoved(HAND, at))

    def release(self) -> None:
        """It lifts."""
        self._submit(PokeReleased(HAND))

    def set_settings(self, settings: ControlSettings) -> None:
        """Change the controller, at the next tick."""
        self._submit(ControlChanged(settings))

    def set_effects(self, effects: Effects) -> None:
        """Simulate otherwise from the next tick on; what cannot be is refused then, and told."""
        self._submit(EffectsChanged(effects))

    def set_behaviours(self, behaviours: tuple[Behaviour, ...]) -> None:
        """Let contact events trigger these from the next tick on, and no others."""
        self._submit(BehavioursChanged(behaviours))

    def set_reading(self, settings: ReadingSettings) -> None:
        """Read contacts otherwise from the next tick on."""
        self._submit(ReadingChanged(settings))

    def edit_map(self, map_: TactileMap, name: str) -> None:
        """Contacts are placed and controlled by an edited map, from the next tick on."""
        if self._running and map_ is not self._map:
            self._map = self._shown_map = map_
            self._submit(MapEdited(name, map_))

    def _tell_map(self, map_: TactileMap) -> None:
        if map_ is not self._shown_map:
            self._shown_map = map_
            self.map_changed.emit(map_)

    def _submit(self, act: SessionInput) -> bool:
        """Whether there is a running session that takes it."""
        if running := self._running:
            running.submit(act)
            self._active_settings.ask(act)
        return running is not None

    def touches(self) -> tuple[Stimulus, ...]:
        """What the hand did since the last reset, as a script; nothing while no session runs."""
        if (running := self._running) is None:
            return ()
        with running.lock:
            session, inputs, tick = running.session, tuple(running.session.inputs), running.session.frame.tick
        prepared = session.prepared
        return stimuli_from_pokes(prepared.skin, inputs, tick=prepared.scene.tick, last=tick)

    def done(self) -> ComparisonStimulus | None:
        """All that was done since the last reset of what is shown, to compare controllers on; None while nothing is."""
        if self.player is not None:
            player = self.player
            return ComparisonStimulus(player.prepared, tuple(player.inputs), float(player.times[-1]))
        if self.runner is None:
            return None
        with self.runner.lock:
            session = self.runner.session
            return ComparisonStimulus(session.prepared, tuple(session.inputs), session.frame.time)

    def scripted(self, scene: Scene) -> ComparisonStimulus | None:
        """The script of ``scene``, as it is simulated now, with the map in force; None while nothing is shown."""
        done, map_ = self.done(), self._shown_map
        if done is None or map_ is None:
            return None
        return ComparisonStimulus(replace(done.prepared, scene=scene, map=map_), None, SCRIPT_SECONDS)

    def set_paused(self, *, paused: bool) -> None:
        """Stop or go on."""
        if running := self._running:
            running.paused = paused
            self.mode_changed.emit(self.mode)

    def set_speed(self, speed: float) -> None:
        """Simulated seconds per second, in this scene and those opened after it."""
        self._speed = speed
        if self.runner is not None:
            self.runner.speed = speed


FRAME_MS = 16


class LiveSession(RunningSession):
    """Owns session, runner, worker, recorder and player; the only caller that changes the session.

    Args:
        parent: Qt parent.
        backends: What does the work.
    """

    def __init__(self, parent: QObject | None = None, *, backends: Backends = BACKGROUND) -> None:
        super().__init__(parent)
        self._engines = backends
        self._recording_writer, self._was_paused = RecordingWriter(), False
        self._live: PreparedScene | None = None
        self._shown: Frame | None = None
        self.worker, self.map_quality_worker, self.cost_worker = (
            backends.worker(self),
            backends.map_quality_worker(self),
            backends.cost_worker(self),
        )
        self.worker.progressed.connect(self.loading)
        self.worker.prepared.connect(self.show_prepared)
        self.worker.failed.connect(self._on_worker_failed)
        self.map_quality_worker.measured.connect(self.measured)
        self.map_quality_worker.failed.connect(self.failed)
        self._timer = QTimer(self)
        self._timer.setInterval(FRAME_MS)
        self._timer.timeout.connect(self.pump)
        self._timer.start()

    def open_scene(self, scene: Scene) -> None:
        """Prepare a scene; the one that runs goes on until the new one is ready."""
        self.loading.emit(f"Opening {scene.robot}", 0.0)
        self.worker.prepare(scene)

    def cancel_loading(self) -> None:
        """Stop preparing; what runs goes on."""
        self.worker.cancel()
        self.loading_ended.emit()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Run a prepared scene from its start."""
        self.loading_ended.emit()
        try:
            session = Session(prepared)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return
        self.stop_recording()
        self._drop_player()
        if self.runner is not None:
            self.runner.stop()
        self._live, self._shown = prepared, None
        self._map = self._shown_map = prepared.map
        self.runner = self._engines.runner(session, self._on_tick, speed=self._speed)
        self._show_other(prepared)
        self._active_settings.begin(session)
        self.mode_changed.emit(self.mode)
        self.pump()

    @property
    def recorder(self) -> Recorder | None:
        """What writes the recording, if one is being written."""
        return self._recording_writer.recorder

    @property
    def prepared(self) -> PreparedScene | None:
        """What is shown now, live or replayed."""
        return self.player.prepared if self.player is not None else self._live

    def step(self) -> None:
        """One tick while paused."""
        if (running := self._running) and running.paused:
            running.step()
            self.pump()

    def reset(self) -> None:
        """Start the scene again; a recording ends where it is."""
        if running := self._running:
            self.stop_recording()
            halted = running.halted
            running.reset()
            for act in self._active_settings.waiting(running.session):  # asked for while paused
                running.submit(act)
            self._shown = None
            if halted:
                self.set_paused(paused=False)
            self.pump()

    def pump(self) -> None:
        """Hand on the newest frame, if there is one, and any failure."""
        if (running := self._running) is None:
            return
        with running.lock:
            frame, failure, running.failure = running.session.frame, running.failure, None
            behaved = self._active_settings.behaved(running.session)
        if (torn := self._recording_writer.take_failure()) is not None:
            self.failed.emit(str(torn))
            self.recording_changed.emit(None)
        if failure is not None:
            self._take_failure(running, failure)
        if behaved is not None:
            self._active_settings.ask(behaved)
            self.triggered.emit(behaved.by)
        if frame is not self._shown:
            self._shown = frame
            self.frame_ready.emit(frame)

    def _take_failure(self, running: SessionRunner, failure: TactileMapsError) -> None:
        """The session stands still, or an input was refused and it goes on."""
        if running.halted:
            self.stop_recording()
            self.halted.emit(str(failure))
            self.mode_changed.emit(self.mode)
        else:
            self._active_settings.begin(running.session)
            self.failed.emit(str(failure))

    def start_recording(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Record every tick from now on to a new file."""
        running = self._running
        if running is None or self._live is None or self._recording_writer.recorder is not None:
            return
        try:
            self._recording_writer.begin(Recorder(path, self._live, overwrite=overwrite))
        except TactileMapsError as error:
            self.failed.emit(str(error))
        else:
            self.recording_changed.emit(str(path))

    def stop_recording(self) -> None:
        """Complete the file."""
        if self.runner is None or self._recording_writer.recorder is None:
            return
        try:
            self.saved.emit(str(self._recording_writer.complete()))
        except TactileMapsError as error:
            self.failed.emit(str(error))
        self.recording_changed.emit(None)

    @property
    def can_report(self) -> bool:
        """Whether the session stopped by itself in a way that a report can repeat."""
        return self._running is not None and self._running.session.failure is not None

    def save_report(self, path: Path) -> None:
        """Keep what led to the stop in a file that replays and repeats it."""
        running = self._running
        if running is None or not self.can_report:
            return
        try:
            make_recording_folder(path.parent)
            with running.lock:
                save_failure_report(running.session, path)
        except TactileMapsError as error:
            self.failed.emit(str(error))
        else:
            self.saved.emit(str(path))

    def open_recording(self, path: str | Path) -> None:
        """Replay a recording; the live session waits."""
        try:
            player = RecordingPlayer(path)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return
        self.stop_recording()
        if running := self._running:
            self._was_paused, running.paused = running.paused, True
        self.player, self._shown, self._shown_map = player, None, player.prepared.map
        self._show_other(player.prepared)
        self.player_changed.emit(player)
        self.mode_changed.emit(self.mode)
        self.show_time(0.0)

    def show_time(self, seconds: float) -> None:
        """Show the recording's frame at ``seconds`` from its start."""
        if self.player is None:
            return
        try:
            frame = self.player.frame(self.player.number_at(seconds))
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return
        if self._shown is None or frame.tick != self._shown.tick:
            self._shown = frame
            rules = self.player.runtime_settings_at(frame.tick)
            self._active_settings.tell(rules)
            self._tell_map(rules.map)
            self.frame_ready.emit(frame)

    def back_to_live(self) -> None:
        """Leave the recording."""
        if self.player is None:
            return
        self._drop_player()
        if self._live is not None and self.runner is not None:
            self.runner.paused = self._was_paused
            self._show_other(self._live)
            self._shown_map = self._live.map
            if self._active_settings.asked is not None:
                self._active_settings.tell(self._active_settings.asked)
        self.mode_changed.emit(self.mode)
        self.pump()

    def _show_other(self, prepared: PreparedScene) -> None:
        self._active_settings.forget()
        self.prepared_changed.emit(prepared)

    def close(self) -> None:
        """Complete the recording, end thread and process."""
        self._timer.stop()
        self.stop_recording()
        if self.runner is not None:
            self.runner.stop()
        self.worker.close()
        self.map_quality_worker.close()
        self.cost_worker.close()

    def _drop_player(self) -> None:
        if self.player is not None:
            self.player, self._shown = None, None
            self.player_changed.emit(None)

    def _on_tick(self, frame: Frame) -> None:
        """Every tick, under the runner's lock, on its thread: no signals here."""
        if self.runner is not None:
            self._recording_writer.write(frame, self.runner.session.inputs)

    def _on_worker_failed(self, text: str) -> None:
        self.loading_ended.emit()
        self.failed.emit(text)

"""The running session behind the window: the only caller that changes it. Intents come in, facts go out as signals."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from app.control.command import ControlChanged, ControlSettings
from app.errors import TactileMapsError
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.session.frame import Frame
from app.session.inputs import MapEdited, SessionInput
from app.session.prepare import Prepared
from app.session.session import Session
from app.simulation.poke import Finger, PokeMoved, PokePressed, PokeReleased
from app.simulation.scene import Scene
from widgets.engines import BESIDE, Engines
from widgets.runner import Runner
from widgets.session_facts import SessionFacts
from widgets.tape import Tape, settings_at

FRAME_MS = 16
HAND = 1
"""Id of the hand's finger; the scripted one has 0."""


class LiveSession(SessionFacts):
    """Owns session, runner, worker, recorder and player.

    Args:
        parent: Qt parent.
        engines: What does the work.
    """

    def __init__(self, parent: QObject | None = None, *, engines: Engines = BESIDE) -> None:
        super().__init__(parent)
        self._engines = engines
        self.runner: Runner | None = None
        self.player: Player | None = None
        self.finger = Finger()
        self._tape, self._speed = Tape(), 1.0
        self._halted = self._was_paused = False
        self._live: Prepared | None = None
        self._map: TactileMap | None = None  # in force in the session; the player's may be shown meanwhile
        self._shown_map: TactileMap | None = None
        self._shown: Frame | None = None
        self._settings: ControlSettings | None = None
        self._wanted = ControlSettings()
        self.worker, self.measurer = engines.worker(self), engines.measurer(self)
        self.worker.progressed.connect(self.loading)
        self.worker.prepared.connect(self.show_prepared)
        self.worker.failed.connect(self._on_worker_failed)
        self.measurer.measured.connect(self.measured)
        self.measurer.failed.connect(self.failed)
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

    def show_prepared(self, prepared: Prepared) -> None:
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
        self._live, self._shown, self._halted = prepared, None, False
        self._map = self._shown_map = prepared.map
        self.runner = self._engines.runner(session, self._on_tick)
        self.runner.speed = self._speed
        self.prepared_changed.emit(prepared)
        self._wanted = session.settings
        self._tell_settings(self._wanted)
        self.mode_changed.emit(self.mode)
        self.pump()

    @property
    def mode(self) -> str:
        """``empty``, ``live``, ``paused`` or ``replaying``."""
        if self.player is not None:
            return "replaying"
        if self.runner is None:
            return "empty"
        return "paused" if self.runner.paused else "live"

    @property
    def _running(self) -> Runner | None:
        """The runner, while what it runs is what is shown."""
        return self.runner if self.player is None else None

    @property
    def recorder(self) -> Recorder | None:
        """What writes the recording, if one is being written."""
        return self._tape.recorder

    @property
    def prepared(self) -> Prepared | None:
        """What is shown now, live or replayed."""
        return self.player.prepared if self.player is not None else self._live

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
        if self._submit(ControlChanged(settings)):
            self._wanted = settings
            self._tell_settings(settings)

    def edit_map(self, map_: TactileMap, name: str) -> None:
        """Contacts are placed and controlled by an edited map, from the next tick on."""
        if (running := self._running) and map_ is not self._map:
            self._map = self._shown_map = map_
            running.submit(MapEdited(name, map_))

    def _tell_map(self, map_: TactileMap) -> None:
        if map_ is not self._shown_map:
            self._shown_map = map_
            self.map_changed.emit(map_)

    def _submit(self, act: SessionInput) -> bool:
        """Whether there is a running session that takes it."""
        if running := self._running:
            running.submit(act)
        return running is not None

    def _tell_settings(self, settings: ControlSettings) -> None:
        if settings != self._settings:
            self._settings = settings
            self.settings_changed.emit(settings)

    def set_paused(self, *, paused: bool) -> None:
        """Stop or go on."""
        if running := self._running:
            running.paused = paused
            self.mode_changed.emit(self.mode)

    def step(self) -> None:
        """One tick while paused."""
        if (running := self._running) and running.paused:
            running.step()
            self.pump()

    def reset(self) -> None:
        """Start the scene again; a recording ends where it is."""
        if running := self._running:
            self.stop_recording()
            running.reset()
            if self._wanted != running.session.settings:  # asked for while paused, it has not taken effect yet
                running.submit(ControlChanged(self._wanted))
            self._shown = None
            if self._halted:
                self._halted = False
                self.set_paused(paused=False)
            self.pump()

    def set_speed(self, speed: float) -> None:
        """Simulated seconds per second, in this scene and those opened after it."""
        self._speed = speed
        if self.runner is not None:
            self.runner.speed = speed

    def pump(self) -> None:
        """Hand on the newest frame, if there is one, and any failure."""
        if (running := self._running) is None:
            return
        with running.lock:
            frame, failure = running.session.frame, running.failure
            torn, running.failure = self._tape.take_failure(), None
        if torn is not None:
            self.failed.emit(str(torn))
            self.recording_changed.emit(None)
        if failure is not None:
            self._halted = True
            self.stop_recording()
            self.halted.emit(str(failure))
            self.mode_changed.emit(self.mode)
        if frame is not self._shown:
            self._shown = frame
            self.frame_ready.emit(frame)

    def start_recording(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Record every tick from now on to a new file."""
        running = self._running
        if running is None or self._live is None or self._tape.recorder is not None:
            return
        try:
            self._tape.begin(path, self._live, running.lock, overwrite=overwrite)
        except TactileMapsError as error:
            self.failed.emit(str(error))
        else:
            self.recording_changed.emit(str(path))

    def stop_recording(self) -> None:
        """Complete the file."""
        if self.runner is None or self._tape.recorder is None:
            return
        try:
            self.saved.emit(str(self._tape.complete(self.runner.lock)))
        except TactileMapsError as error:
            self.failed.emit(str(error))
        self.recording_changed.emit(None)

    def open_recording(self, path: str | Path) -> None:
        """Replay a recording; the live session waits."""
        try:
            player = Player(path)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return
        self.stop_recording()
        if running := self._running:
            self._was_paused, running.paused = running.paused, True
        self.player, self._shown, self._shown_map = player, None, player.prepared.map
        self.prepared_changed.emit(player.prepared)
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
            self._tell_settings(settings_at(self.player.inputs, frame.tick))
            self._tell_map(self.player.map_at(frame.tick))
            self.frame_ready.emit(frame)

    def back_to_live(self) -> None:
        """Leave the recording."""
        if self.player is None:
            return
        self._drop_player()
        if self._live is not None and self.runner is not None:
            self.runner.paused = self._was_paused
            self.prepared_changed.emit(self._live)
            self._shown_map = self._live.map
            self._tell_settings(self._wanted)
        self.mode_changed.emit(self.mode)
        self.pump()

    def close(self) -> None:
        """Complete the recording, end thread and process."""
        self._timer.stop()
        self.stop_recording()
        if self.runner is not None:
            self.runner.stop()
        self.worker.close()
        self.measurer.close()

    def _drop_player(self) -> None:
        if self.player is not None:
            self.player, self._shown = None, None
            self.player_changed.emit(None)

    def _on_tick(self, frame: Frame) -> None:
        """Every tick, under the runner's lock, on its thread: no signals here."""
        if self.runner is not None:
            self._tape.write(frame, self.runner.session.inputs)

    def _on_worker_failed(self, text: str) -> None:
        self.loading_ended.emit()
        self.failed.emit(text)

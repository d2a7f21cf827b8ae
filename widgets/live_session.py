"""The session behind the window: opened, run, recorded, replayed. Intents come in, facts go out as signals."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from app.errors import TactileMapsError
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.recording.report import save_report
from app.scene.scene import Scene
from app.session.frame import Frame
from app.session.prepare import Prepared
from app.session.session import Session
from widgets.engines import BESIDE, Engines
from widgets.runner import Runner
from widgets.running_session import RunningSession
from widgets.tape import Tape, make_folder

FRAME_MS = 16


class LiveSession(RunningSession):
    """Owns session, runner, worker, recorder and player; the only caller that changes the session.

    Args:
        parent: Qt parent.
        engines: What does the work.
    """

    def __init__(self, parent: QObject | None = None, *, engines: Engines = BESIDE) -> None:
        super().__init__(parent)
        self._engines = engines
        self._tape, self._was_paused = Tape(), False
        self._live: Prepared | None = None
        self._shown: Frame | None = None
        self.worker, self.measurer, self.bench = engines.worker(self), engines.measurer(self), engines.bench(self)
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
        self._live, self._shown = prepared, None
        self._map = self._shown_map = prepared.map
        self.runner = self._engines.runner(session, self._on_tick)
        self.runner.speed = self._speed
        self._show_other(prepared)
        self._in_force.begin(session)
        self.mode_changed.emit(self.mode)
        self.pump()

    @property
    def recorder(self) -> Recorder | None:
        """What writes the recording, if one is being written."""
        return self._tape.recorder

    @property
    def prepared(self) -> Prepared | None:
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
            for act in self._in_force.waiting(running.session):  # asked for while paused
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
            frame, failure = running.session.frame, running.failure
            torn, running.failure = self._tape.take_failure(), None
            behaved = self._in_force.behaved(running.session)
        if torn is not None:
            self.failed.emit(str(torn))
            self.recording_changed.emit(None)
        if failure is not None:
            self._take_failure(running, failure)
        if behaved is not None:
            self._in_force.ask(behaved)
            self.triggered.emit(behaved.by)
        if frame is not self._shown:
            self._shown = frame
            self.frame_ready.emit(frame)

    def _take_failure(self, running: Runner, failure: TactileMapsError) -> None:
        """The session stands still, or an input was refused and it goes on."""
        if running.halted:
            self.stop_recording()
            self.halted.emit(str(failure))
            self.mode_changed.emit(self.mode)
        else:
            self._in_force.begin(running.session)
            self.failed.emit(str(failure))

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
            make_folder(path.parent)
            with running.lock:
                save_report(running.session, path)
        except TactileMapsError as error:
            self.failed.emit(str(error))
        else:
            self.saved.emit(str(path))

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
            rules = self.player.rules_at(frame.tick)
            self._in_force.tell(rules)
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
            if self._in_force.asked is not None:
                self._in_force.tell(self._in_force.asked)
        self.mode_changed.emit(self.mode)
        self.pump()

    def _show_other(self, prepared: Prepared) -> None:
        self._in_force.forget()
        self.prepared_changed.emit(prepared)

    def close(self) -> None:
        """Complete the recording, end thread and process."""
        self._timer.stop()
        self.stop_recording()
        if self.runner is not None:
            self.runner.stop()
        self.worker.close()
        self.measurer.close()
        self.bench.close()

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

"""Host of the session or recording that the window shows: opens, runs and changes it.

Recording, replay, the connection to a real skin and sharing are parts with their own methods and signals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.scene import Scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import (
    BehavioursChanged,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    PosturePlaced,
    ReadingChanged,
    RestChanged,
    SessionInput,
)
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import find_prepared
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.session.session import Session
from tactile_maps.stimuli.stimuli_from_pokes import stimuli_from_pokes
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_widgets.common.mode import Mode
from tactile_widgets.jobs.scene_jobs import SceneFile, SceneJobs
from tactile_widgets.session.backends import BACKGROUND, Backends
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus
from tactile_widgets.session.live_input import LiveConnection, LiveInput
from tactile_widgets.session.measurements import Measurements
from tactile_widgets.session.recording_control import RecordingControl
from tactile_widgets.session.reference_comparison import ReferenceComparison
from tactile_widgets.session.replay_control import ReplayControl
from tactile_widgets.session.session_run import ActiveSettings, SessionRun, Source
from tactile_widgets.session.session_runner import SessionRunner
from tactile_widgets.session.sharing import Sharing
from tactile_widgets.session.skin_comparison import SkinComparison

SCRIPT_SECONDS = 10.0
"""Default duration of a comparison on the script of a scene [s]."""
FRAME_MS = 16
POSTURE_SPEED = 0.6
"""Speed of the fastest joint when the robot moves to a target posture [rad/s, or m/s]."""


class SessionHost(QObject):
    """Holds the session or recording that is shown; the only code that changes the session.

    Signals report changes after they happened.

    Args:
        parent: Qt parent.
        backends: Factories of runners, writers and executors.

    Attributes:
        scene_jobs: Opens scenes and recordings, flattens patches.
        measurements: Measures maps and costs in the background.
        recording: Records the running session.
        sharing: Shows the session in viewers of other programs.
        replay: Shows a recording instead of the running session.
        connection: Shows readings of a real skin instead of a simulation.
        skin_comparison: Compares these readings with a simulation.
        reference: Compares the running scene with a finer simulation.
        admit: Called with a function that shows what was opened in the background, and with its scene unless it is a
            recording or continues one; calls the function at once or later.
        opening: Whether something is being opened, or waits to be shown.
        opening_recording: The recording that is being opened, or waits to be shown; None without one.
    """

    frame_ready = Signal(object)
    """Newest Frame, simulated, measured or replayed; at most once per drawn frame."""
    frames_passed = Signal(object)
    """Tuple of the frames between the previous one shown and the newest, which ``frame_ready`` reports next."""
    prepared_changed = Signal(object)
    """PreparedScene that is shown now."""
    loading = Signal(str, float)
    """Progress of opening a scene or recording: the stage, and the share done, 0 to 1."""
    loading_ended = Signal()
    """Opening has finished, failed or been cancelled."""
    opening_stopped = Signal()
    """Opening failed or was cancelled; what was shown before is kept."""
    failed = Signal(str)
    """Message about something that failed, with place and remedy. The previous state is kept."""
    halted = Signal(str)
    """Reason why the simulation failed and stopped; ``reset`` starts it again."""
    mode_changed = Signal(Mode)
    """Mode; also emitted if it may not have changed."""
    settings_changed = Signal(object)
    """Current ControlSettings."""
    effects_changed = Signal(object)
    """Current Effects."""
    reading_changed = Signal(object)
    """Current ReadingSettings."""
    behaviours_changed = Signal(object)
    """Current tuple of Behaviour."""
    triggered = Signal(object)
    """ControlTrigger of a behaviour that changed the controller."""

    def __init__(self, parent: QObject | None = None, *, backends: Backends = BACKGROUND) -> None:
        super().__init__(parent)
        self._backends = backends
        self._speed = 1.0
        self._run: SessionRun | None = None
        self._was_paused = False  # the session before the running one
        self._shown: Frame | None = None
        self.admit: Callable[[Callable[[], None], Scene | None], None] = lambda show, _scene: show()
        self.opening = False
        self.opening_recording: Path | None = None
        self.recording = RecordingControl(self, backends.recording_writer(), self)
        self.replay = ReplayControl(self, self)
        self.connection = LiveConnection(self, self)
        self.sharing = Sharing(self, self)
        self.frame_ready.connect(self.sharing.show_frame)
        self._active_settings = ActiveSettings(
            settings=self.settings_changed.emit,
            effects=self.effects_changed.emit,
            behaviours=self.behaviours_changed.emit,
            reading=self.reading_changed.emit,
        )
        self._make_jobs()
        self._timer = QTimer(self)
        self._timer.setInterval(FRAME_MS)
        self._timer.timeout.connect(self.pump)
        self._timer.start()

    def _make_jobs(self) -> None:
        self.scene_jobs = SceneJobs(self._backends.executor("prepare", self), self)
        self.measurements = Measurements(self._backends, self)
        self.skin_comparison = SkinComparison(self._backends, self)
        self.reference = ReferenceComparison(self._backends, self)
        self.connection.changed.connect(self.skin_comparison.show_input)
        self.scene_jobs.progressed.connect(self.loading)
        self.scene_jobs.prepared.connect(self._on_prepared)
        self.scene_jobs.opened.connect(self._on_opened)
        self.scene_jobs.failed.connect(self._on_opening_failed)
        self.measurements.map_failed.connect(self.failed)
        self.measurements.cost_failed.connect(self.failed)

    # What is shown.

    @property
    def source(self) -> Source | None:
        """The replayed recording, else the running scene; None before the first."""
        return self.replay.current or self._run

    @property
    def mode(self) -> Mode:
        """Mode of the window."""
        return Mode.EMPTY if self.source is None else self.source.mode

    @property
    def prepared(self) -> PreparedScene | None:
        """The scene that is shown, running or replayed."""
        return None if self.source is None else self.source.prepared

    @property
    def shown(self) -> Frame | None:
        """The frame that is shown; None before the first."""
        return self._shown

    @property
    def simulating(self) -> bool:
        """True if a simulation that is shown runs or is paused, so that it can be touched."""
        return self.shown_run is not None and self.live_input is None

    @property
    def simulates_behind(self) -> bool:
        """True if there is a simulation, shown or behind a recording."""
        return self._run is not None and self.live_input is None

    @property
    def run(self) -> SessionRun | None:
        """The running session, or the one paused behind a recording; None before the first."""
        return self._run

    @property
    def runner(self) -> SessionRunner | None:
        """Runner of that session; None before the first."""
        return None if self._run is None else self._run.runner

    @property
    def live_input(self) -> LiveInput | None:
        """Readings of a real skin that are shown instead of a simulation; None for a simulation."""
        return self.connection.input

    @property
    def measured_from(self) -> str | None:
        """Address of the readings of a real skin that are shown; None for a simulation."""
        return None if self.live_input is None else self.live_input.connection.source.address

    @property
    def shown_run(self) -> SessionRun | None:
        """The running session if it is shown; None during a replay."""
        return self._run if self.replay.current is None else None

    def report_progress(self, stage: str, fraction: float) -> None:
        """Emit ``loading``."""
        self.opening = True
        self.loading.emit(stage, fraction)

    def end_progress(self) -> None:
        """Emit ``loading_ended``."""
        self.opening = False
        self.opening_recording = None
        self.loading_ended.emit()

    def report_failure(self, text: str) -> None:
        """Emit ``failed``."""
        self.failed.emit(text)

    def pump(self) -> None:
        """Report the newest frame of the running session, and any failure."""
        self.recording.check()
        if (run := self.shown_run) is None:
            return
        update = run.update()
        if update.failure is not None:
            self._report_run_failure(run, update.failure)
        self._active_settings.show(run.settings)
        if update.behaved is not None:
            self.triggered.emit(update.behaved.by)
        if update.frame is not self._shown:
            self._shown = update.frame
            self.report_frame(update.frame, tuple(frame for frame in update.passed if frame is not update.frame))
            self.skin_comparison.show_frame(update.frame)
            if self.live_input is None:
                self.reference.show_frame(run.runner.session, update.frame)

    def report_frame(self, frame: Frame, passed: tuple[Frame, ...] | None) -> None:
        """Report the frame that is shown, and the frames since the previous one; None if it does not follow that."""
        if passed is not None:
            self.frames_passed.emit(passed)
        self.frame_ready.emit(frame)

    def _report_run_failure(self, run: SessionRun, failure: TactileMapsError) -> None:
        """Report that the session stopped, or that it rejected an input and continues."""
        if run.runner.halted:
            self.recording.stop()
            self.halted.emit(str(failure))
            self.mode_changed.emit(self.mode)
        else:
            self._active_settings.show(run.settings)
            self.failed.emit(str(failure))

    def _show_other(self, prepared: PreparedScene) -> None:
        """Show something else, and drop measurements of the previous scene."""
        self._shown = None
        self._active_settings.forget()
        self.measurements.show_scene()
        self.prepared_changed.emit(prepared)
        self.sharing.restart()

    # Opening.

    def open_scene(self, scene: Scene, *, file: Path | None = None) -> None:
        """Prepare a scene; the running one continues until the new one is ready.

        Args:
            scene: The scene.
            file: File that the scene was read from; its references are then checked too, and errors name its line.
        """
        self.report_progress(f"Opening {scene.robot}", 0.0)
        if file is None and self._show_kept(scene):
            return
        self.scene_jobs.prepare(scene if file is None else SceneFile(file, scene.package_roots))

    def _show_kept(self, scene: Scene) -> bool:
        """Show the scene at once if robot, skin and map are cached; return whether they are."""
        try:
            kept = find_prepared(scene)
        except TactileMapsError:
            return False  # the job reports it
        if kept is not None:
            self.scene_jobs.drop()
            self._show_opened(kept)
        return kept is not None

    def open_recording(self, path: str | Path) -> None:
        """Read a recording; the current session continues until it is ready."""
        self.cancel_loading()
        path = Path(path)
        self.report_progress(f"Opening {path.name}", 0.0)
        self.opening_recording = path
        self.scene_jobs.open_recording(path)

    def cancel_loading(self) -> None:
        """Stop opening; the current session continues."""
        if self.opening:
            self.scene_jobs.cancel()
            self.replay.cancel_take_over()
            self._stop_opening()

    def _stop_opening(self) -> None:
        self.end_progress()
        self.opening_stopped.emit()

    def _on_opening_failed(self, text: str) -> None:
        self._stop_opening()
        self.failed.emit(text)

    def _on_prepared(self, prepared: PreparedScene) -> None:
        self.admit(partial(self._show_opened, prepared), prepared.scene)

    def _on_opened(self, player: RecordingPlayer) -> None:
        self.admit(partial(self.show_player, player), None)

    def _show_opened(self, prepared: PreparedScene) -> None:
        self.end_progress()
        if not self.show_prepared(prepared):
            self.opening_stopped.emit()

    def show_prepared(self, prepared: PreparedScene, settings: RuntimeSettings | None = None) -> bool:
        """Run a prepared scene from its start; return whether it runs.

        Args:
            prepared: The scene.
            settings: Initial controller, effects, behaviours, contact detection and map; by default those of the scene.
        """
        try:
            start = settings or RuntimeSettings.of_scene(prepared)
            session = Session(
                prepared,
                map_=start.map,
                settings=start.settings,
                effects=start.effects,
                behaviours=start.behaviours,
                reading=start.reading,
            )
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return False
        self.run_session(session)
        return True

    def run_session(self, session: Session) -> None:
        """Run a session from its start instead of the previous one."""
        self._end_run()
        self._begin_run(
            self._backends.runner(
                session, lambda frame: self.recording.writer.write(frame, session.inputs), speed=self._speed
            )
        )

    def _end_run(self) -> None:
        run = self.shown_run
        self._was_paused = run is not None and run.runner.paused and not run.runner.halted
        self.recording.stop()
        self.replay.discard()
        if self._run is not None:
            self._run.runner.stop()
        self.connection.discard()

    def _begin_run(self, runner: SessionRunner) -> None:
        self._run = SessionRun(runner)
        self._show_other(self._run.prepared)
        self._active_settings.show(self._run.settings)
        self.mode_changed.emit(self.mode)
        runner.start()  # last, because its first ticks would not be shown, and would slow down building the views
        self.pump()

    def run_readings(self, live: LiveInput) -> None:
        """Show readings of a real skin instead of the previous session."""
        self.cancel_loading()
        session = live.session
        self._end_run()
        self.connection.input = live
        self._begin_run(
            live.run(self._backends.readings_runner, lambda frame: self.recording.writer.write(frame, session.inputs))
        )

    # Replay.

    def show_player(self, player: RecordingPlayer) -> None:
        """Replay a recording; the running session is paused."""
        self.end_progress()
        self.recording.stop()
        self.replay.show(player)

    def begin_replay(self, prepared: PreparedScene) -> None:
        """Show the scene of a recording instead of the running session."""
        self.mode_changed.emit(self.mode)  # first, so that an incomplete edit is cancelled on its own map
        self._show_other(prepared)

    def end_replay(self, *, paused: bool) -> None:
        """Show the running session again, paused or not."""
        if (run := self._run) is not None:
            self._show_other(run.prepared)
            self._active_settings.show(run.settings)
            run.runner.paused = paused
        self.mode_changed.emit(self.mode)
        self.pump()

    def set_replayed(self, frame: Frame, settings: RuntimeSettings) -> None:
        """Show a frame of the recording, with its settings."""
        self._shown = frame
        self._active_settings.show(settings)

    # Inputs of the user.

    def submit(self, *session_inputs: SessionInput) -> bool:
        """Pass inputs to the running session for the next tick; return False if no running session is shown."""
        if (run := self.shown_run) is None:
            return False
        run.submit(*session_inputs)
        self._active_settings.show(run.settings)
        return True

    def set_settings(self, settings: ControlSettings) -> None:
        """Change the controller at the next tick."""
        self.submit(ControlChanged(settings))

    def set_effects(self, effects: Effects) -> None:
        """Change the simulated effects at the next tick; effects that are rejected then are reported."""
        self.submit(EffectsChanged(effects))

    def set_behaviours(self, behaviours: tuple[Behaviour, ...]) -> None:
        """Replace the behaviours that contact events trigger, at the next tick."""
        self.submit(BehavioursChanged(behaviours))

    def set_reading(self, settings: ReadingSettings) -> None:
        """Change the detection of contacts at the next tick."""
        self.submit(ReadingChanged(settings))

    def move_robot(self, posture: FloatArray) -> None:
        """Move the robot to a posture (n,) under its controller, as its new home posture, from the next tick on."""
        self.submit(RestChanged(tuple(posture.tolist()), POSTURE_SPEED))

    def place_robot(self, posture: FloatArray) -> TactileMapsError | None:
        """Place the robot of a paused scene in a posture (n,), which takes a tick; return why it is rejected."""
        run = self.shown_run
        if run is None or not run.runner.paused:
            return None
        run.submit(PosturePlaced(tuple(posture.tolist())))
        refused = run.runner.failure
        run.runner.failure = None
        if refused is None:
            self.step()
        return refused

    def edit_map(self, map_: TactileMap, name: str, settings: ControlSettings | None = None) -> None:
        """Locate and control contacts on an edited map from the next tick on.

        Args:
            map_: The edited map.
            name: Name of the edit.
            settings: Settings of the controller with the path on that map; None for the current ones.
        """
        if (run := self.shown_run) is None or map_ is run.map:
            return
        inputs: list[SessionInput] = [MapEdited(name, map_)]
        if settings is not None and settings != run.settings.settings:
            inputs.append(ControlChanged(settings))
        self.submit(*inputs)

    # Time.

    def set_paused(self, *, paused: bool) -> None:
        """Pause or continue."""
        if run := self.shown_run:
            run.runner.paused = paused
            self.mode_changed.emit(self.mode)

    def set_speed(self, speed: float) -> None:
        """Set the simulated seconds per wall second of this scene and of scenes opened later."""
        self._speed = speed
        if self._run is not None:
            self._run.runner.speed = speed

    def keep_pause(self) -> None:
        """Pause the session that is about to start if the session before it was paused."""
        if self._run is not None:
            self._run.runner.paused = self._was_paused

    def step(self) -> None:
        """Advance a paused session by one tick."""
        if (run := self.shown_run) and run.runner.paused:
            run.runner.step()
            self.pump()

    def reset(self) -> None:
        """Restart the scene; a recording ends."""
        if run := self.shown_run:
            self.recording.stop()
            halted = run.reset()
            self._shown = None
            if halted:
                self.set_paused(paused=False)
            self.pump()

    # Inputs so far.

    def touches(self) -> tuple[Stimulus, ...]:
        """Return the touches of the user since the last reset as a script; empty if no running session is shown."""
        if (run := self.shown_run) is None:
            return ()
        with run.runner.lock:
            session = run.runner.session
            inputs = tuple(session.inputs)
            tick = session.frame.tick
        prepared = run.prepared
        return stimuli_from_pokes(prepared.skin, inputs, tick=prepared.scene.tick, last=tick)

    def done(self) -> ComparisonStimulus | None:
        """Return the inputs since the last reset as a stimulus for comparisons; None if nothing is shown."""
        return None if self.source is None else self.source.record()

    def scripted(self, scene: Scene) -> ComparisonStimulus | None:
        """Return the script of ``scene`` as a stimulus, with the current map; None if nothing is shown."""
        if (source := self.source) is None:
            return None
        prepared = replace(source.prepared, scene=scene, map=source.settings.map)
        return ComparisonStimulus(prepared, None, SCRIPT_SECONDS)

    def close(self) -> None:
        """Complete the recording, and end threads and processes."""
        self._timer.stop()
        self.replay.cancel_take_over()
        self.sharing.stop()
        self.recording.close()
        if self._run is not None:
            self._run.runner.stop()
        self.scene_jobs.close()
        self.measurements.close()
        self.skin_comparison.close()
        self.reference.close()

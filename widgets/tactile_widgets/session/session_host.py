"""The session behind the window: opening, running, and which session or recording is shown.

Recording, replay, the connection to a real skin and sharing are parts with their own methods and signals.
"""

from __future__ import annotations

from dataclasses import replace
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
from tactile_widgets.session.comparison import ComparisonStimulus
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
"""A script is compared on for so long, unless a person says otherwise."""
FRAME_MS = 16
POSTURE_SPEED = 0.6
"""At which the robot goes to a posture that is wanted: its fastest joint [rad/s, or m/s]."""


class SessionHost(QObject):
    """What is shown and what a person may do to it; the only caller that changes the session.

    Signals are past-tense changes; none asks for an answer.

    Args:
        parent: Qt parent.
        backends: What does the work.

    Attributes:
        scene_jobs: Opens scenes and recordings, flattens patches.
        measurements: What is measured beside of what is shown.
        recording: Records the session that runs.
        sharing: Shows it in viewers of other programs.
        replay: Shows a recording instead of the session that runs.
        connection: Shows readings of a real skin instead of a simulation.
        skin_comparison: Simulates beside them.
        reference: Simulates the scene that runs once more, finer.
    """

    frame_ready = Signal(object)
    """The newest Frame, at most once a drawn frame; live or replayed."""
    frames_passed = Signal(object)
    """The frames between the one shown before and the newest, which ``frame_ready`` hands on next: a tuple."""
    prepared_changed = Signal(object)
    """Another PreparedScene is shown from now on."""
    loading = Signal(str, float)
    """A scene or a recording is being opened: the stage, and 0 to 1."""
    loading_ended = Signal()
    """It is not any more: done, failed or cancelled."""
    failed = Signal(str)
    """Something could not be done; the sentence says what, where and what helps. All that was good is kept."""
    halted = Signal(str)
    """The simulation failed and stands still; the sentence says why. ``reset`` starts it again."""
    mode_changed = Signal(Mode)
    """The mode, after it may have changed."""
    settings_changed = Signal(object)
    """ControlSettings in force."""
    effects_changed = Signal(object)
    """Effects in force."""
    reading_changed = Signal(object)
    """ReadingSettings in force."""
    behaviours_changed = Signal(object)
    """The tuple of Behaviour in force."""
    triggered = Signal(object)
    """A behaviour changed the controller: the ControlTrigger."""

    def __init__(self, parent: QObject | None = None, *, backends: Backends = BACKGROUND) -> None:
        super().__init__(parent)
        self._backends = backends
        self._speed = 1.0
        self._run: SessionRun | None = None
        self._shown: Frame | None = None
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
        self.scene_jobs.prepared.connect(self.show_prepared)
        self.scene_jobs.opened.connect(self.show_player)
        self.scene_jobs.failed.connect(self._on_opening_failed)
        self.measurements.map_failed.connect(self.failed)
        self.measurements.cost_failed.connect(self.failed)

    # What is shown.

    @property
    def source(self) -> Source | None:
        """What is shown: the recording that is replayed, else the scene that runs; None before there is either."""
        return self.replay.current or self._run

    @property
    def mode(self) -> Mode:
        """Mode of the window."""
        return Mode.EMPTY if self.source is None else self.source.mode

    @property
    def prepared(self) -> PreparedScene | None:
        """The scene that is shown, live or replayed."""
        return None if self.source is None else self.source.prepared

    @property
    def shown(self) -> Frame | None:
        """The frame that is shown; None before the first."""
        return self._shown

    @property
    def simulating(self) -> bool:
        """Whether what is shown is a simulation that runs: it can be touched."""
        return self.shown_run is not None and self.live_input is None

    @property
    def simulates_behind(self) -> bool:
        """Whether a simulation runs or waits, shown or not."""
        return self._run is not None and self.live_input is None

    @property
    def run(self) -> SessionRun | None:
        """The scene that runs, or waits behind a recording; None before there is one."""
        return self._run

    @property
    def runner(self) -> SessionRunner | None:
        """Of the scene that runs, shown or not; None before there is one."""
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
        """The session that runs, if it is shown; None during a replay."""
        return self._run if self.replay.current is None else None

    def report_progress(self, stage: str, fraction: float) -> None:
        """Emit ``loading``."""
        self.loading.emit(stage, fraction)

    def end_progress(self) -> None:
        """Emit ``loading_ended``."""
        self.loading_ended.emit()

    def report_failure(self, text: str) -> None:
        """Emit ``failed``."""
        self.failed.emit(text)

    def pump(self) -> None:
        """Hand on the newest frame of the scene that runs, if there is one, and any failure."""
        self.recording.check()
        if (run := self.shown_run) is None:
            return
        update = run.update()
        if update.failure is not None:
            self._tell_failure(run, update.failure)
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

    def _tell_failure(self, run: SessionRun, failure: TactileMapsError) -> None:
        """The session stands still, or an input was refused and it goes on."""
        if run.runner.halted:
            self.recording.stop()
            self.halted.emit(str(failure))
            self.mode_changed.emit(self.mode)
        else:
            self._active_settings.show(run.settings)
            self.failed.emit(str(failure))

    def _show_other(self, prepared: PreparedScene) -> None:
        """Something else is shown. What was measured on the scene before is not of this one."""
        self._shown = None
        self._active_settings.forget()
        self.measurements.show_scene()
        self.prepared_changed.emit(prepared)
        self.sharing.restart()

    # Opening.

    def open_scene(self, scene: Scene, *, file: Path | None = None) -> None:
        """Prepare a scene; the one that runs goes on until the new one is ready.

        Args:
            scene: Which.
            file: Where it was read; what it names is then checked too, and errors name its line.
        """
        self.loading.emit(f"Opening {scene.robot}", 0.0)
        if file is None and self._show_kept(scene):
            return
        self.scene_jobs.prepare(scene if file is None else SceneFile(file, scene.package_roots))

    def _show_kept(self, scene: Scene) -> bool:
        """Whether robot, skin and map are kept from before: shown at once then, sooner than a process starts."""
        try:
            kept = find_prepared(scene)
        except TactileMapsError:
            return False  # the job reports it
        if kept is not None:
            self.scene_jobs.drop()
            self.show_prepared(kept)
        return kept is not None

    def open_recording(self, path: str | Path) -> None:
        """Read a recording; what is shown goes on until it is ready."""
        self.loading.emit(f"Opening {Path(path).name}", 0.0)
        self.scene_jobs.open_recording(Path(path))

    def cancel_loading(self) -> None:
        """Stop opening; what is shown goes on."""
        self.scene_jobs.cancel()
        self.replay.cancel_take_over()
        self.loading_ended.emit()

    def _on_opening_failed(self, text: str) -> None:
        self.loading_ended.emit()
        self.failed.emit(text)

    def show_prepared(self, prepared: PreparedScene, settings: RuntimeSettings | None = None) -> None:
        """Run a prepared scene from its start.

        Args:
            prepared: The scene.
            settings: Initial controller, effects, behaviours, contact detection and map; by default those of the scene.
        """
        self.loading_ended.emit()
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
            return
        self.run_session(session)

    def run_session(self, session: Session) -> None:
        """Run a session from its start, in place of what ran before."""
        self._end_run()
        self._begin_run(
            self._backends.runner(
                session, lambda frame: self.recording.writer.write(frame, session.inputs), speed=self._speed
            )
        )

    def _end_run(self) -> None:
        """Something else will run."""
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
        runner.start()  # not before: its first ticks would be seen by nobody, and take their time from what shows them
        self.pump()

    def run_readings(self, live: LiveInput) -> None:
        """Show readings of a real skin, in place of what is shown."""
        session = live.session
        self._end_run()
        self.connection.input = live
        self._begin_run(
            live.run(self._backends.readings_runner, lambda frame: self.recording.writer.write(frame, session.inputs))
        )

    # Replay.

    def show_player(self, player: RecordingPlayer) -> None:
        """Replay a recording; the session that runs is paused."""
        self.loading_ended.emit()
        self.recording.stop()
        self.replay.show(player)

    def begin_replay(self, prepared: PreparedScene) -> None:
        """Show the scene of a recording instead of the session that runs."""
        self.mode_changed.emit(self.mode)  # first: an edit that is not complete is cancelled on its own map
        self._show_other(prepared)

    def end_replay(self, *, paused: bool) -> None:
        """Show the session that runs again, paused or not."""
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

    # What a person does to the scene that runs.

    def submit(self, session_input: SessionInput) -> bool:
        """Pass an input to the running session for the next tick. Whether there is one, and it is shown."""
        if (run := self.shown_run) is None:
            return False
        run.submit(session_input)
        self._active_settings.show(run.settings)
        return True

    def set_settings(self, settings: ControlSettings) -> None:
        """Change the controller, at the next tick."""
        self.submit(ControlChanged(settings))

    def set_effects(self, effects: Effects) -> None:
        """Simulate otherwise from the next tick on; what cannot be is refused then, and told."""
        self.submit(EffectsChanged(effects))

    def set_behaviours(self, behaviours: tuple[Behaviour, ...]) -> None:
        """Let contact events trigger these from the next tick on, and no others."""
        self.submit(BehavioursChanged(behaviours))

    def set_reading(self, settings: ReadingSettings) -> None:
        """Read contacts otherwise from the next tick on."""
        self.submit(ReadingChanged(settings))

    def move_robot(self, posture: FloatArray) -> None:
        """The robot goes to a posture (n,) under its controller, from the next tick on, where it holds its rest."""
        self.submit(RestChanged(tuple(posture.tolist()), POSTURE_SPEED))

    def place_robot(self, posture: FloatArray) -> TactileMapsError | None:
        """The robot of a paused scene stands in a posture (n,) at once, which takes a tick; why not, where refused."""
        run = self.shown_run
        if run is None or not run.runner.paused:
            return None
        run.submit(PosturePlaced(tuple(posture.tolist())))
        refused = run.runner.failure
        run.runner.failure = None
        if refused is None:
            self.step()
        return refused

    def edit_map(self, map_: TactileMap, name: str) -> None:
        """Contacts are placed and controlled by an edited map, from the next tick on."""
        if (run := self.shown_run) is not None and map_ is not run.map:
            self.submit(MapEdited(name, map_))

    # Time.

    def set_paused(self, *, paused: bool) -> None:
        """Stop or go on."""
        if run := self.shown_run:
            run.runner.paused = paused
            self.mode_changed.emit(self.mode)

    def set_speed(self, speed: float) -> None:
        """Simulated seconds per second, in this scene and those opened after it."""
        self._speed = speed
        if self._run is not None:
            self._run.runner.speed = speed

    def step(self) -> None:
        """One tick while paused."""
        if (run := self.shown_run) and run.runner.paused:
            run.runner.step()
            self.pump()

    def reset(self) -> None:
        """Restart the scene; a recording ends where it is."""
        if run := self.shown_run:
            self.recording.stop()
            halted = run.reset()
            self._shown = None
            if halted:
                self.set_paused(paused=False)
            self.pump()

    # What was done.

    def touches(self) -> tuple[Stimulus, ...]:
        """What the user did since the last reset, as a script; nothing while no session runs."""
        if (run := self.shown_run) is None:
            return ()
        with run.runner.lock:
            session = run.runner.session
            inputs = tuple(session.inputs)
            tick = session.frame.tick
        prepared = run.prepared
        return stimuli_from_pokes(prepared.skin, inputs, tick=prepared.scene.tick, last=tick)

    def done(self) -> ComparisonStimulus | None:
        """All that was done since the last reset of what is shown, to compare controllers on; None while nothing is."""
        return None if self.source is None else self.source.record()

    def scripted(self, scene: Scene) -> ComparisonStimulus | None:
        """The script of ``scene``, as it is simulated now, with the map in force; None while nothing is shown."""
        if (source := self.source) is None:
            return None
        prepared = replace(source.prepared, scene=scene, map=source.settings.map)
        return ComparisonStimulus(prepared, None, SCRIPT_SECONDS)

    def close(self) -> None:
        """Complete the recording, end thread and process."""
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

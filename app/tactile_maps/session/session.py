"""A session: one run of a prepared scene, advanced tick by tick, answering with frozen frames.

A control tick is a whole number of physics steps (``substeps``), and the controller is told how often, how late and up
to which pressure the scene's sensor reads (``skin_readings``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from tactile_maps.contacts.detection.below_threshold import BelowThreshold
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.pipeline import ContactPipeline, ReadingSettings
from tactile_maps.control.behaviours import Behaviour, BehaviourTrigger, tasks_of
from tactile_maps.control.controller_manager import ControllerManager
from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.unmeasured_force import DriveTorques
from tactile_maps.control.path_following.clearance import Obstacle
from tactile_maps.core.arrays import FloatArray, all_finite, seal
from tactile_maps.core.errors import MapError, PluginError, SceneError, SimulationError, TactileMapsError
from tactile_maps.core.timing import Stopwatch
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.motion import Motion
from tactile_maps.scene.scene import Scene, whole_steps
from tactile_maps.session.frame import Failure, Frame
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import (
    BehavioursChanged,
    CalibrationUsed,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    PosturePlaced,
    ReadingChanged,
    RestChanged,
    SessionInput,
    remembered,
)
from tactile_maps.session.obstacles import obstacles_of
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Skin
from tactile_maps.stimuli.stimulus_player import StimulusPlayer
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased


def substeps(tick: float, timestep: float) -> int:
    """Physics steps in one control tick.

    Raises:
        SimulationError: The tick is not a whole number of them.
    """
    try:
        return whole_steps(tick, timestep)
    except SceneError as error:
        raise error.at(kind=SimulationError) from error


def skin_readings(effects: Effects, tick: float) -> SensorTiming:
    """At every ``tick`` [s], at once and without an end; but for ``sampling``, ``saturation`` and ``time_averaging``.

    The mean over the time since the last sample is as old as the middle of that time.
    """
    bus = effects.sensor.sampling
    amplifier = effects.sensor.saturation
    highest = math.inf if amplifier is None else amplifier.at
    averaged = effects.time_averaging
    if bus is None:
        return SensorTiming(tick, highest=highest, averaged=averaged)
    period = max(1 / bus.rate, tick)
    return SensorTiming(period, bus.delay + (0.5 * period if averaged else 0.0), highest, averaged)


def _checked_map(map_: TactileMap, skin: Skin) -> TactileMap:
    """The map, if its skin has the taxels of ``skin``; they may be believed to lie elsewhere.

    Raises:
        MapError: It is of another skin.
    """
    covered, mapped = (tuple((patch.link, len(patch.taxels)) for patch in one.patches) for one in (skin, map_.skin))
    if covered != mapped:
        raise MapError(
            "the map is of another skin",
            value=f"{len(map_.skin)} taxels on {len(mapped)} patches",
            remedy=f"Use a map of the session's skin, with {len(skin)} taxels on {len(covered)} patches",
        )
    return map_


class Session:
    """Physics, touch, contacts and control of one scene. Mutable; ``reset`` starts again.

    Reads no clock but for stage times. Whatever changes its course comes through ``submit`` or is the script;
    both stand in ``inputs`` with the tick they took effect at, and the same inputs at the same ticks give the same
    frames, bit for bit.

    Args:
        prepared: The scene, made real.
        scripted: Whether the scene's script plays until a person touches.
        map_: The scene's map as it was edited before; or one of a skin whose taxels are the same but are believed to
            lie elsewhere, which contacts are read and controlled by then.
        settings: The controller's settings to start with; by default those of the scene.
        effects: What to simulate; by default what the scene calls for.
        behaviours: What contact events trigger; by default those of the scene.
        reading: How contacts are read; by default as the scene says.

    Attributes:
        frame: The newest frame.
        inputs: (tick, input) since the reset, in order; the tick is that of the first frame that shows it.
        scripted: Whether the script still plays.
        map: The tactile map in force: the scene's, until it is edited.
        failure: Why the session stopped by itself; None while it goes on.

    Raises:
        TactileMapsError: The scene and its effects cannot be simulated.

    Example:
        >>> session = tm.Session.of(robot, tactile_map)
        >>> session.press(skin.taxel_point(30), force=3.0)
        >>> frame = session.run_for(4.0)  # the arm yields while the finger advances
        >>> print(f"{frame.regions[0].force:.1f} N on {frame.regions[0].link}")
        3.0 N on hand
    """

    def __init__(
        self,
        prepared: PreparedScene,
        *,
        scripted: bool = True,
        map_: TactileMap | None = None,
        settings: ControlSettings | None = None,
        effects: Effects | None = None,
        behaviours: Sequence[Behaviour] | None = None,
        reading: ReadingSettings | None = None,
    ) -> None:
        self.prepared = prepared
        self._wants_script = scripted
        scene = prepared.scene
        robot = prepared.robot
        skin = prepared.skin
        self._start = RuntimeSettings.of_scene(prepared)
        effects = effects or self._start.effects
        self._steps = substeps(scene.tick, effects.timestep)
        self._simulation = Simulation(
            robot, skin, effects, objects=prepared.objects, layer=scene.layer, tick=scene.tick, seed=scene.seed
        )
        self.map = self._start.map if map_ is None else _checked_map(map_, skin)
        self._contacts = ContactPipeline(
            robot,
            self.map,
            effects.sensor,
            settings=reading or self._start.reading,
            depth=scene.layer.depth,
            seed=scene.seed,
        )
        self._below_threshold = BelowThreshold(skin)
        self._controller = ControllerManager(
            robot, self.map, settings or self._start.settings, surroundings=self._surroundings
        )
        self._state_errors(effects)
        self._controller.readings = skin_readings(effects, scene.tick)
        self._behaviours = BehaviourTrigger(skin, self._start.behaviours if behaviours is None else behaviours)
        self._controller.prepare((self.settings.task, *tasks_of(self._behaviours.behaviours)), self.map)
        self._motion = Motion(robot, scene.motion) if scene.motion else None
        self._stimulus = StimulusPlayer(skin, scene.stimuli, tick=scene.tick)
        self._watch = Stopwatch()
        self._watchers: list[Callable[[Frame], None]] = []
        self.reset()

    @classmethod
    def of(cls, robot: Robot, map_: TactileMap, *, settings: ControlSettings | None = None) -> Session:
        """A session of a robot in the skin of a map, alone in the world, with nobody touching it yet.

        Args:
            robot: Which the skin covers.
            map_: The tactile map of its skin.
            settings: Of the controller; by default impedance, which holds the home posture.
        """
        scene = Scene(name=robot.name, robot=robot.name)
        return cls(PreparedScene(scene, robot, map_.skin, map_), settings=settings)

    def reset(self) -> None:
        """Back to the start: robot at home, objects in their places, no finger, the script playing.

        Settings, the edited map and the effects in force stay; settings that a behaviour changed until the release
        are those from before again.
        """
        self._simulation.reset()
        self._contacts.reset()
        self._below_threshold.reset()
        self._unreported: tuple[ContactNote, ...] = ()
        self._controller.reset()
        self._controller.rest = self.prepared.robot.home
        self._rest_goal: RestChanged | None = None  # on the way to which the rest posture is
        before = self._behaviours.reset()
        if before is not None:
            self._controller.settings = before
        self._waiting: list[SessionInput] = []
        # What is in force is part of what a replay needs, the settings even where they are the scene's.
        runtime_settings = self.runtime_settings
        others = [
            session_input
            for session_input in runtime_settings.since(self._start)
            if not isinstance(session_input, ControlChanged)
        ]
        self.inputs = InputLog((0, one) for one in (ControlChanged(runtime_settings.settings), *others))
        self._ticks = 0
        self.failure: Failure | None = None
        self.scripted = self._wants_script and bool(self.prepared.scene.stimuli)
        self.frame = self._frame()

    @property
    def settings(self) -> ControlSettings:
        """The controller settings in force."""
        return self._controller.settings

    @property
    def effects(self) -> Effects:
        """The effects in force."""
        return self._simulation.effects

    @property
    def runtime_settings(self) -> RuntimeSettings:
        """All that a person may change, as it is in force."""
        return RuntimeSettings(
            self.settings, self.effects, self._behaviours.behaviours, self._contacts.settings, self.map
        )

    @property
    def total_normal_force(self) -> float:
        """How hard all that touches truly presses the skin at this tick [N], whatever the sensor makes of it."""
        return self._simulation.total_normal_force

    def submit(self, session_input: SessionInput) -> None:
        """Let a person do something at the start of the next tick. The first press ends the script.

        What a behaviour did in a recorded session is not taken: it is derived again.

        Raises:
            MapError: The map of an edit is of another skin; the session is as if it had not come.
            RobotError: MuJoCo refuses the shapes that collide, which a path task needs; likewise.
            SimulationError: A posture is none of the robot's, the scene moves the robot itself, the robot is to be
                placed while something touches it, or it is the calibration of a real skin; likewise.
        """
        if isinstance(session_input, MapEdited):
            _checked_map(session_input.map, self.prepared.skin)
        if isinstance(session_input, RestChanged | PosturePlaced):
            self._check_posture(session_input.posture)
        if isinstance(session_input, RestChanged):
            self._check_speed(session_input.speed)
        if isinstance(session_input, PosturePlaced):
            self._check_free(session_input.posture)
        if isinstance(session_input, ControlChanged) and session_input.by is not None:
            return
        self._prepare_control(session_input)
        if isinstance(session_input, CalibrationUsed):
            remedy = "Show its readings with: tactile-maps listen"
            raise SimulationError("a simulated skin has no calibration: a real one was recorded", remedy=remedy)
        if isinstance(session_input, PokePressed) and self.scripted:
            self._end_script()
        self._waiting.append(session_input)

    def _prepare_control(self, session_input: SessionInput) -> None:
        """What the controller will need from the next tick on is built now, not within a tick.

        With what waits for that tick already: a map and a task may come one after the other, in either order.
        """
        if not isinstance(session_input, ControlChanged | BehavioursChanged | MapEdited):
            return
        tasks = [self.settings.task, *tasks_of(self._behaviours.behaviours)]
        map_ = self.map
        for coming in (*self._waiting, session_input):
            match coming:
                case ControlChanged(settings=settings):
                    tasks.append(settings.task)
                case BehavioursChanged(behaviours=behaviours):
                    tasks += tasks_of(behaviours)
                case MapEdited():
                    map_ = coming.map
        self._controller.prepare(tasks, map_)

    def _check_speed(self, speed: float | None) -> None:
        if speed is not None and not (math.isfinite(speed) and speed > 0):
            raise SimulationError("there is no such speed", value=speed, remedy="Give rad/s above 0, or None")

    def _check_free(self, posture: tuple[float, ...]) -> None:
        """Raise an error if anything touches the robot, in its current posture or in ``posture``."""
        remedy = "Let it move there instead: play, and set the posture again"
        if self._simulation.pokes:
            raise SimulationError("a finger presses the robot, which cannot be placed elsewhere then", remedy=remedy)
        for where, at in (("where it stands", self._simulation.posture), ("there", np.array(posture))):
            if touching := self._simulation.touching(at):
                raise SimulationError(
                    f"the robot cannot be placed: something touches it {where}", value=touching, remedy=remedy
                )

    def _check_posture(self, posture: tuple[float, ...]) -> None:
        joints = self.prepared.robot.joints
        if self._motion is not None:
            remedy = "Leave motion out of the scene"
            raise SimulationError("the scene moves the robot's rest posture itself", remedy=remedy)
        pairs = zip(joints, posture, strict=False)
        if len(posture) != len(joints) or not all(joint.lower <= x <= joint.upper for joint, x in pairs):
            remedy = f"Give {len(joints)} positions within the joints' limits"
            raise SimulationError("this is no posture of the robot", value=posture, remedy=remedy)

    def press(self, at: SurfacePoint, *, force: float = 3.0, finger: int = 1) -> None:
        """Press the skin with a finger from the next tick on, until ``release``.

        The finger advances until it pushes with ``force``, and follows a skin that yields. Pressing elsewhere with a
        finger that is down moves it there.

        Args:
            at: Where: a point of the skin, such as ``Skin.taxel_point`` and ``TactileMap.to_body`` give.
            force: Along the skin's inward normal, in the end [N].
            finger: Which.

        Raises:
            SimulationError: There is no such force; a place that is not on the skin is refused by the tick.
        """
        self.submit(PokePressed(finger, at, Finger(max_force=force)))

    def release(self, *, finger: int = 1) -> None:
        """Lift a finger at the next tick."""
        self.submit(PokeReleased(finger))

    @contextmanager
    def watched(self, each: Callable[[Frame], None]) -> Iterator[None]:
        """Tell ``each`` the frame of every tick while the block runs, however the session is stepped."""
        self._watchers.append(each)
        try:
            yield
        finally:
            self._watchers.remove(each)

    def run_for(self, seconds: float) -> Frame:
        """Simulate ``seconds``, rounded to whole ticks, as fast as it goes; the last frame.

        Raises:
            SimulationError: There is no such time.
            TactileMapsError: As ``tick``.
        """
        if not (math.isfinite(seconds) and seconds >= 0):
            raise SimulationError("the duration is out of range", value=f"{seconds} s", remedy="Choose 0 s or more")
        for _ in range(round(seconds / self.prepared.scene.tick)):
            self.tick()
        return self.frame

    def tick(self) -> Frame:
        """One control tick: inputs, physics, touch, contacts, control.

        Raises:
            TactileMapsError: An input was refused; the session is as if it had not come. Where the script was
                refused, its show has ended.
            SimulationError: The physics diverged, or a plug-in failed at work. ``failure`` says all about it, and until
                ``reset`` every tick raises the same again.
        """
        if self.failure is not None:
            raise self.failure.error
        self._take_effect()
        try:
            with self._watch.stage("physics"):
                self._simulation.sum_wrenches(self._contacts.needs_wrenches)
                self._simulation.step(self._steps, self._command)
            self._ticks += 1
            self.frame = self._frame()
            self._trigger()
        except (SimulationError, PluginError) as error:
            # A plug-in that failed in the middle of a tick stops the session as physics that diverged does.
            stop = error if isinstance(error, SimulationError) else SimulationError(
                error.problem, file=error.file, place=error.place, value=error.value, remedy=error.remedy
            )  # fmt: skip
            self.failure = Failure(self.frame.tick + 1, stop, tuple(self.inputs), self.frame)
            if stop is error:
                raise
            raise stop from error
        for each in tuple(self._watchers):
            each(self.frame)
        return self.frame

    def _take_effect(self) -> None:
        self._apply_waiting()
        # Without the effect, fingers cannot reach the skin: the script goes on unseen.
        if self.scripted and self.effects.fingers:
            self._waiting += self._stimulus.inputs(self._ticks)
            try:
                self._apply_waiting()
            except TactileMapsError:
                self._end_script()  # it would be refused again at this tick, for ever
                raise

    def _end_script(self) -> None:
        self.scripted = False
        self._waiting += [PokeReleased(finger) for finger in self._stimulus.fingers]

    def _apply_waiting(self) -> None:
        while self._waiting:
            session_input = self._waiting.pop(0)
            if isinstance(session_input, ControlChanged):
                self._controller.settings = session_input.settings
                if session_input.by is None:
                    self._behaviours.settled()
            elif isinstance(session_input, BehavioursChanged):
                self._behaviours.use(session_input.behaviours)
            elif isinstance(session_input, MapEdited):
                self._contacts.use(session_input.map)
                self._controller.use(session_input.map)
                self.map = session_input.map
            elif isinstance(session_input, EffectsChanged):
                self._use(session_input.effects)
            elif isinstance(session_input, ReadingChanged):
                self._contacts.settings = session_input.settings
            elif isinstance(session_input, RestChanged):
                self._change_rest(session_input)
            elif isinstance(session_input, PosturePlaced):
                self._place(session_input.posture)
            elif not isinstance(session_input, CalibrationUsed):  # which is refused
                self._simulation.apply(session_input)
            self.inputs.append(self._ticks + 1, remembered(session_input))

    def _change_rest(self, change: RestChanged) -> None:
        self._rest_goal = None if change.speed is None else change
        if change.speed is None:
            self._controller.rest = np.array(change.posture)

    def _place(self, posture: tuple[float, ...]) -> None:
        self._check_free(posture)  # what touches may have come since it was asked for
        self._simulation.place(np.array(posture))
        self._controller.reset()
        self._controller.rest = np.array(posture)
        self._rest_goal = None
        # The command in force is about the posture before, and would pull for a tick.
        still = np.zeros(len(posture))
        self._command = self._controller.command(Observation(np.array(posture), still, (), self.prepared.scene.tick))

    def _move_rest(self) -> None:
        """The rest posture goes on its straight way in joint space; all joints arrive together."""
        goal = self._rest_goal
        if goal is None or goal.speed is None:
            return
        away = np.array(goal.posture) - self._controller.rest
        farthest = float(np.abs(away).max(initial=0.0))
        step = goal.speed * self.prepared.scene.tick
        if farthest <= step:
            self._controller.rest = np.array(goal.posture)
            self._rest_goal = None
        else:
            self._controller.rest = self._controller.rest + away * (step / farthest)

    def _trigger(self) -> None:
        """Let what has happened at this tick change the controller at the next."""
        frame = self.frame
        changed = self._behaviours.triggered(frame.events, self.settings, touched=self._contacts.touched)
        if changed is not None:
            self._waiting.append(ControlChanged(changed[0], by=changed[1]))

    def _use(self, effects: Effects) -> None:
        steps = substeps(self.prepared.scene.tick, effects.timestep)
        self._simulation.use(effects)
        self._state_errors(effects)
        self._controller.readings = skin_readings(effects, self.prepared.scene.tick)
        self._steps = steps

    def _state_errors(self, effects: Effects) -> None:
        averaged = self.prepared.scene.tick if effects.time_averaging else 0.0
        self._contacts.set_sensor_model(effects.sensor, averaged=averaged, model=effects.skin)
        self._contacts.set_broken_taxels(self._simulation.broken_taxels)

    def _frame(self) -> Frame:
        simulation = self._simulation
        watch = self._watch
        time = self._ticks * self.prepared.scene.tick
        posture = simulation.posture
        velocity = simulation.velocity
        tick = self.prepared.scene.tick
        seal(posture, velocity)
        pressures, regions = self._touch(time, posture)
        with watch.stage("control"):
            if self._motion is not None:
                self._controller.rest = self._motion.posture(time)
            self._move_rest()
            observation = Observation(
                posture,
                velocity,
                regions,
                tick,
                readable=all_finite(pressures),
                mismatch=self._contacts.mismatch,
                torques=self._drive_torques,
            )
            self._command = self._controller.command(observation)
        return Frame(
            tick=self._ticks,
            time=time,
            posture=posture,
            velocity=velocity,
            pressures=pressures,
            regions=regions,
            pokes=simulation.pokes,
            command=self._command,
            why_limited=self._controller.why_limited,
            timings=watch.take(),
            objects=simulation.object_poses,
            notes=(*simulation.notes, *self._unreported, *(area.note for area in self._contacts.blind)),
            recent=self._contacts.recent,
            task=self._controller.report,
            estimates=self._contacts.estimates,
        )

    @property
    def _drive_torques(self) -> DriveTorques | None:
        """Torques of the drives in the last tick; None where the physics knows none."""
        mean = self._simulation.drive_torque
        effects = self.effects
        if mean is None:
            return None
        return DriveTorques(mean, gravity=effects.gravity == "on", dry_friction=effects.joint_friction)

    def _surroundings(self) -> tuple[Obstacle, ...]:
        return obstacles_of(self.prepared.objects, self._simulation.object_poses)

    def _touch(self, time: float, posture: FloatArray) -> tuple[FloatArray, tuple[ContactRegion, ...]]:
        """What the skin reads, stage by stage, and the contacts in it; neither where no skin is simulated."""
        pressures = np.zeros(len(self.prepared.skin))
        stages = self._simulation.readings
        true = pressures
        for number, (name, stage) in enumerate(stages):
            with self._watch.stage(name):
                pressures = stage(pressures)
            true = true if number else pressures
        if not stages:
            self._unreported = ()
            return pressures, self._contacts.read(self._ticks, time, posture, None)
        with self._watch.stage("contacts"):
            wrenches = self._simulation.wrenches() if self._contacts.needs_wrenches else {}
            regions = self._contacts.read(self._ticks, time, posture, pressures, wrenches=wrenches)
            self._unreported = self._below_threshold.notes(
                time, true, self._contacts.threshold, regions, lambda: self._simulation.loads
            )
            return pressures, regions

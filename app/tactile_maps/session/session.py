"""Simulated session: one run of a prepared scene, advanced tick by tick, with a frozen frame for each tick.

A control tick is a whole number of physics steps. The controller receives period, delay and upper limit of the
sensor's readings (``skin_readings``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

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
from tactile_maps.core.errors import MapError, PluginError, SceneError, SimulationError, TactileMapsError, counted
from tactile_maps.core.timing import Stopwatch
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.model.taxel_frames import taxel_frames
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
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokePulled, PokeReleased


def substeps(tick: float, timestep: float) -> int:
    """Return the number of physics steps in one control tick.

    Raises:
        SimulationError: The tick [s] is not a whole number of time steps [s].
    """
    try:
        return whole_steps(tick, timestep)
    except SceneError as error:
        raise error.at(kind=SimulationError) from error


def skin_readings(effects: Effects, tick: float) -> SensorTiming:
    """Return the timing and the upper limit of the sensor's readings.

    Without ``sampling``, ``saturation`` and ``time_averaging`` there is one reading per ``tick`` [s], without delay and
    limit. A mean over the time since the last sample is as old as the middle of that time.
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
    """Return the map if it has the taxels of ``skin``; their assumed positions may differ.

    Raises:
        MapError: It belongs to another skin.
    """
    covered, mapped = (tuple((patch.link, len(patch.taxels)) for patch in one.patches) for one in (skin, map_.skin))
    if covered != mapped:
        sizes = [f"{counted(len(one), 'taxel')} on {counted(len(one.patches), 'patch')}" for one in (map_.skin, skin)]
        remedy = f"Use a map of the session's skin, with {sizes[1]}"
        raise MapError("the map is of another skin", value=sizes[0], remedy=remedy)
    return map_


class Session:
    """Physics, touch, contacts and control of one scene. Mutable; ``reset`` starts again.

    It reads the clock only to time its stages. All changes are inputs, from ``submit`` or from the script, and are
    listed in ``inputs`` with the tick at which they took effect. The same inputs at the same ticks produce the same
    frames, bit for bit.

    Args:
        prepared: The prepared scene.
        scripted: Play the scene's stimulus script until the user presses the skin.
        map_: Edited map of the scene's skin, or a map of a skin with the same taxels at other assumed positions;
            contacts are then read and controlled with these positions. By default the scene's map.
        settings: Initial settings of the controller; by default those of the scene.
        effects: Simulated effects; by default those of the scene.
        behaviours: Reactions to contact events; by default those of the scene.
        reading: Settings of the contact detection; by default those of the scene.

    Attributes:
        frame: The newest frame.
        inputs: (tick, input) since the reset, in order; the tick is that of the first frame that shows it.
        scripted: Whether the script is playing.
        map: The current tactile map.
        failure: Failure that stopped the session; None while it can continue.

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
        scene = prepared.scene
        robot = prepared.robot
        skin = prepared.skin
        self._starts_scripted = scripted and bool(scene.stimuli)
        self._start = RuntimeSettings.of_scene(prepared)
        effects = effects or self._start.effects
        self._steps = substeps(scene.tick, effects.timestep)
        self.map = self._start.map if map_ is None else _checked_map(map_, skin)
        self._simulation = Simulation(
            robot,
            skin,
            effects,
            objects=prepared.objects,
            layer=scene.layer,
            tick=scene.tick,
            seed=scene.seed,
            frames=lambda: taxel_frames(self.map),
        )
        self._contacts = ContactPipeline(
            robot,
            self.map,
            effects.sensor,
            settings=reading or self._start.reading,
            depth=scene.layer.depth,
            seed=scene.seed,
            friction=scene.layer.friction or 0.5,
        )
        self._below_threshold = BelowThreshold(skin)
        self._controller = ControllerManager(
            robot,
            self.map,
            settings or self._start.settings,
            surroundings=self._surroundings,
            stiffness=scene.layer.stiffness,
        )
        self._set_sensor(effects)
        self._behaviours = BehaviourTrigger(skin, self._start.behaviours if behaviours is None else behaviours)
        self._controller.prepare((self.settings.task, *tasks_of(self._behaviours.behaviours)), self.map)
        self._motion = Motion(robot, scene.motion) if scene.motion else None
        self._stimulus = StimulusPlayer(skin, scene.stimuli, tick=scene.tick, repeat=scene.repeat_stimuli)
        self._watch = Stopwatch()
        self._watchers: list[Callable[[Frame], None]] = []
        self.reset()

    @classmethod
    def of(cls, robot: Robot, map_: TactileMap, *, settings: ControlSettings | None = None) -> Session:
        """Create a session of a robot without objects and without stimulus script.

        Args:
            robot: The robot that the skin covers.
            map_: The tactile map of its skin.
            settings: Settings of the controller; by default impedance, which holds the home posture.

        Raises:
            SkinError: The skin is on a link that the robot does not have.
        """
        scene = Scene(name=robot.name, robot=robot.name)
        return cls(PreparedScene(scene, robot, map_.skin, map_), settings=settings)

    def reset(self) -> None:
        """Return to the start: robot at home, objects in their initial poses, no finger, the script playing.

        Settings, edited map and current effects are kept. Settings that a behaviour changed until the release return
        to their previous values.
        """
        self._simulation.reset()
        self._contacts.reset()
        self._below_threshold.reset()
        self._unreported: tuple[ContactNote, ...] = ()
        self._controller.reset()
        self._controller.rest = self.prepared.robot.home
        self._rest_goal: RestChanged | None = None  # target that the rest posture is approaching
        before = self._behaviours.reset()
        if before is not None:
            self._controller.settings = before
        self._waiting: list[SessionInput] = []
        # A replay needs the current settings, those of the controller even where they are the scene's.
        runtime_settings = self.runtime_settings
        changes = runtime_settings.since(replace(self._start, settings=runtime_settings.settings))
        self.inputs = InputLog((0, one) for one in (ControlChanged(runtime_settings.settings), *changes))
        self._ticks = 0
        self.failure: Failure | None = None
        self.scripted = self._starts_scripted
        self.frame = self._frame()

    @property
    def settings(self) -> ControlSettings:
        """The current controller settings."""
        return self._controller.settings

    @property
    def effects(self) -> Effects:
        """The current effects."""
        return self._simulation.effects

    @property
    def runtime_settings(self) -> RuntimeSettings:
        """All current settings that the user can change."""
        return RuntimeSettings(
            self.settings, self.effects, self._behaviours.behaviours, self._contacts.settings, self.map
        )

    @property
    def total_normal_force(self) -> float:
        """True sum of all normal forces on the skin at this tick [N], independent of the sensor."""
        return self._simulation.total_normal_force

    def submit(self, session_input: SessionInput) -> None:
        """Apply an input at the start of the next tick. The first press of the user ends the script.

        Recorded inputs that a behaviour caused are ignored, because the session derives them again.

        Raises:
            MapError: An edited map belongs to another skin. The session is unchanged, as after the other errors.
            RobotError: MuJoCo rejects the collision shapes that a path task needs.
            SimulationError: A posture does not fit the robot, the scene itself moves the robot, the robot is to be
                placed while something touches it, or the input is a calibration, which only a real skin has.
        """
        match session_input:
            case MapEdited(map=edited):
                _checked_map(edited, self.prepared.skin)
            case RestChanged(posture=posture, speed=speed):
                self._check_posture(posture)
                if speed is not None and not (math.isfinite(speed) and speed > 0):
                    remedy = "Choose a value above 0 rad/s, or None"
                    raise SimulationError("the speed of the rest posture is out of range", value=speed, remedy=remedy)
            case PosturePlaced(posture=posture):
                self._check_posture(posture)
                self._check_free(posture)
            case ControlChanged(by=by) if by is not None:
                return
            case CalibrationUsed():
                remedy = "Show its readings with: tactile-maps listen"
                raise SimulationError("a simulated skin has no calibration: a real one was recorded", remedy=remedy)
            case PokePressed() if self.scripted:
                self._end_script()
        self._prepare_control(session_input)
        self._waiting.append(session_input)

    def _prepare_control(self, session_input: SessionInput) -> None:
        """Build what the controller needs from the next tick on, because it takes longer than a tick.

        Inputs that already wait for that tick count as well: a map and a task may arrive in either order.
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

    def _check_free(self, posture: tuple[float, ...]) -> None:
        """Raise an error if anything touches the robot, in its current posture or in ``posture``."""
        remedy = "Let it move there instead: play, and set the posture again"
        if self._simulation.pokes:
            raise SimulationError("the robot cannot be placed while a finger presses it", remedy=remedy)
        for where, at in (("in its current posture", self._simulation.posture), ("there", np.array(posture))):
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
            raise SimulationError("the posture does not fit the robot", value=posture, remedy=remedy)

    def press(self, at: SurfacePoint, *, force: float = 3.0, finger: int = 1) -> None:
        """Press the skin with a finger from the next tick on, until ``release``.

        The finger advances until it pushes with ``force``, and follows a skin that yields. Pressing elsewhere with a
        finger that is down moves it there.

        Args:
            at: Point of the skin, such as ``Skin.taxel_point`` and ``TactileMap.to_body`` return.
            force: Final force along the skin's inward normal [N].
            finger: Identifier of the finger.

        Raises:
            SimulationError: The force is out of range. A point that is not on the skin is rejected by the tick.
        """
        self.submit(PokePressed(finger, at, Finger(max_force=force)))

    def release(self, *, finger: int = 1) -> None:
        """Lift a finger at the next tick."""
        self.submit(PokeReleased(finger))

    @contextmanager
    def watched(self, each: Callable[[Frame], None]) -> Iterator[None]:
        """Call ``each`` with the frame of every tick while the block runs."""
        self._watchers.append(each)
        try:
            yield
        finally:
            self._watchers.remove(each)

    def run_for(self, seconds: float) -> Frame:
        """Simulate ``seconds``, rounded to whole ticks, as fast as possible; return the last frame.

        Raises:
            SimulationError: The duration is out of range, or positive and rounded to no tick.
            TactileMapsError: A tick failed, see ``tick``.
        """
        if not (math.isfinite(seconds) and seconds >= 0):
            raise SimulationError("the duration is out of range", value=f"{seconds} s", remedy="Choose 0 s or more")
        tick = self.prepared.scene.tick
        ticks = round(seconds / tick)
        if seconds > 0 and not ticks:
            remedy = f"Choose at least one tick, {tick:g} s"
            raise SimulationError("the duration is shorter than a tick", value=f"{seconds:g} s", remedy=remedy)
        for _ in range(ticks):
            self.tick()
        return self.frame

    def tick(self) -> Frame:
        """Simulate one control tick: inputs, physics, touch, contacts, control.

        Raises:
            TactileMapsError: An input was rejected; the session is unchanged. If it was an input of the script, the
                script has ended.
            SimulationError: The physics diverged, or a plug-in failed. ``failure`` describes it, and every further
                tick raises the same error until ``reset``.
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
            # A plug-in that fails during a tick stops the session in the same way as physics that diverges.
            stop = error.at(kind=SimulationError)
            self.failure = Failure(self.frame.tick + 1, stop, tuple(self.inputs), self.frame)
            raise stop from error
        for each in tuple(self._watchers):
            each(self.frame)
        return self.frame

    def _take_effect(self) -> None:
        self._apply_waiting()
        # Without the effect, fingers cannot reach the skin, but the script continues.
        if self.scripted and self.effects.fingers:
            self._waiting += self._stimulus.inputs(self._ticks)
            try:
                self._apply_waiting()
            except TactileMapsError:
                self._end_script()  # the same input would be rejected at every further tick
                raise

    def continue_script(self) -> None:
        """Play the script of the scene from the current tick on, unless a press of the user has ended it.

        For a session that was created without the script and received the inputs of one that played it.
        """
        pressed = {act.id for _, act in self.inputs if isinstance(act, PokePressed)}
        self._starts_scripted = bool(self.prepared.scene.stimuli)
        self.scripted = self._starts_scripted and pressed <= set(self._stimulus.fingers)

    def _end_script(self) -> None:
        self.scripted = False
        self._waiting += [PokeReleased(finger) for finger in self._stimulus.fingers]

    def _apply_waiting(self) -> None:
        while self._waiting:
            session_input = self._waiting.pop(0)
            match session_input:
                case ControlChanged(settings=settings, by=by):
                    self._controller.settings = settings
                    if by is None:
                        self._behaviours.settled()
                case BehavioursChanged(behaviours=behaviours):
                    self._behaviours.use(behaviours)
                case MapEdited(map=map_):
                    self._contacts.use(map_)
                    self._controller.use(map_)
                    self.map = map_
                    self._simulation.turn_frames()
                case EffectsChanged(effects=effects):
                    steps = substeps(self.prepared.scene.tick, effects.timestep)
                    self._simulation.use(effects)
                    self._set_sensor(effects)
                    self._steps = steps
                case ReadingChanged(settings=reading):
                    self._contacts.settings = reading
                case RestChanged(posture=posture, speed=None):
                    self._rest_goal = None
                    self._controller.rest = np.array(posture)
                case RestChanged():
                    self._rest_goal = session_input
                case PosturePlaced(posture=posture):
                    self._place(posture)
                case PokePressed() | PokeMoved() | PokePulled() | PokeReleased():
                    self._simulation.apply(session_input)
            self.inputs.append(self._ticks + 1, remembered(session_input))

    def _place(self, posture: tuple[float, ...]) -> None:
        self._check_free(posture)  # a contact may have begun since ``submit``
        self._simulation.place(np.array(posture))
        self._controller.reset()
        self._controller.rest = np.array(posture)
        self._rest_goal = None
        # The last command refers to the previous posture and would pull for one tick.
        still = np.zeros(len(posture))
        self._command = self._controller.command(Observation(np.array(posture), still, (), self.prepared.scene.tick))

    def _move_rest(self) -> None:
        """Move the rest posture one tick along a straight line in joint space; all joints arrive together."""
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
        """Queue the change of settings that the contact events of this tick trigger."""
        changed = self._behaviours.triggered(self.frame.events, self.settings, touched=self._contacts.touched)
        if changed is not None:
            self._waiting.append(ControlChanged(changed[0], by=changed[1]))

    def _set_sensor(self, effects: Effects) -> None:
        tick = self.prepared.scene.tick
        averaged = tick if effects.time_averaging else 0.0
        self._contacts.set_sensor_model(effects.sensor, averaged=averaged, model=effects.skin)
        self._contacts.set_broken_taxels(self._simulation.broken_taxels)
        self._controller.readings = skin_readings(effects, tick)

    def _frame(self) -> Frame:
        simulation = self._simulation
        watch = self._watch
        tick = self.prepared.scene.tick
        time = self._ticks * tick
        posture = simulation.posture
        velocity = simulation.velocity
        seal(posture, velocity)
        pressures, shear, regions = self._touch(time, posture)
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
            shear=shear,
        )

    @property
    def _drive_torques(self) -> DriveTorques | None:
        """Torques of the drives in the last tick; None if the physics does not compute them."""
        mean = self._simulation.drive_torque
        effects = self.effects
        if mean is None:
            return None
        return DriveTorques(mean, gravity=effects.gravity == "on", dry_friction=effects.joint_friction)

    def _surroundings(self) -> tuple[Obstacle, ...]:
        return obstacles_of(self.prepared.objects, self._simulation.object_poses)

    def _touch(
        self, time: float, posture: FloatArray
    ) -> tuple[FloatArray, FloatArray | None, tuple[ContactRegion, ...]]:
        """Return the readings of pressure and shear, stage by stage, and the contacts in them; zeros without a skin."""
        pressures = np.zeros(len(self.prepared.skin))
        stages = self._simulation.readings
        true = pressures
        for number, (name, stage) in enumerate(stages):
            with self._watch.stage(name):
                pressures = stage(pressures)
            true = true if number else pressures
        if not stages:
            self._unreported = ()
            return pressures, None, self._contacts.read(self._ticks, time, posture, None)
        shear = self._simulation.sense_shear()
        with self._watch.stage("contacts"):
            wrenches = self._simulation.wrenches() if self._contacts.needs_wrenches else {}
            regions = self._contacts.read(self._ticks, time, posture, pressures, wrenches=wrenches, shear=shear)
            self._unreported = self._below_threshold.notes(
                time, true, pressures, self._contacts.threshold, regions, lambda: self._simulation.loads
            )
            return pressures, shear, regions

"""A session: one run of a prepared scene, advanced tick by tick, answering with frozen frames."""

from __future__ import annotations

from collections.abc import Callable

from app.contacts.reader import ContactReader
from app.control.command import ControlChanged, ControlSettings
from app.control.contact_motion import ContactMotionController, settings_from
from app.maps.tactile_map import TactileMap
from app.session.frame import Frame
from app.session.inputs import MapEdited, SessionInput
from app.session.prepare import Prepared
from app.simulation.poke import PokePressed, PokeReleased
from app.simulation.simulation import Simulation
from app.simulation.stimuli import FINGER, StimulusPlayer
from app.timing import Stopwatch

MAX_TICKS = 20
"""Of one ``advance``: the rest of the wall time is dropped, so that a slow machine runs slower instead of choking."""


class Session:
    """Physics, touch, contacts and control of one scene. Mutable; ``reset`` starts again.

    Reads no clock but for stage times. Whatever changes its course comes through ``submit`` or is the scripted hand;
    both stand in ``inputs`` with the tick they took effect at, and the same inputs at the same ticks give the same
    frames, bit for bit.

    Args:
        prepared: The scene, made real.
        scripted: Whether the scene's scripted hand plays until a person touches.
        settings: The controller's settings to start with; by default those of the scene.
        map_: The scene's map as it was edited before.

    Attributes:
        frame: The newest frame.
        inputs: (tick, input) since the reset, in order; the tick is that of the first frame that shows it.
        scripted: Whether the scripted hand still plays.
        map: The tactile map in force: the scene's, until it is edited.
    """

    def __init__(
        self,
        prepared: Prepared,
        *,
        scripted: bool = True,
        settings: ControlSettings | None = None,
        map_: TactileMap | None = None,
    ) -> None:
        self.prepared, self._wants_script = prepared, scripted
        scene = prepared.scene
        self._simulation = Simulation(prepared.robot, prepared.skin, scene.effects)
        self.map = map_ or prepared.map
        self._reader = ContactReader(self.map)
        self._controller = ContactMotionController(prepared.robot, settings or settings_from(scene.control))
        self._stimulus = StimulusPlayer(prepared.skin, scene.strokes, tick=scene.tick)
        self._watch = Stopwatch()
        self.reset()

    def reset(self) -> None:
        """Back to the start: robot at home, no finger, the scripted hand playing; settings and the edited map stay."""
        self._simulation.reset()
        self._reader.reset()
        self._controller.reset()
        self._waiting: list[SessionInput] = []
        # The settings and the map in force are part of what a replay needs.
        self.inputs: list[tuple[int, SessionInput]] = [(0, ControlChanged(self._controller.settings))]
        if self.map is not self.prepared.map:
            self.inputs.append((0, MapEdited("As it was edited before", self.map)))
        self._ticks, self._remainder = 0, 0.0
        self.scripted = self._wants_script and bool(self.prepared.scene.strokes)
        self.frame = self._frame()

    @property
    def settings(self) -> ControlSettings:
        """The controller settings in force."""
        return self._controller.settings

    def submit(self, act: SessionInput) -> None:
        """Let a person act at the start of the next tick. The first press ends the scripted hand's show."""
        if isinstance(act, PokePressed) and self.scripted:
            self.scripted = False
            self._waiting.append(PokeReleased(FINGER))
        self._waiting.append(act)

    def advance(self, elapsed: float, *, each: Callable[[Frame], None] | None = None) -> Frame:
        """Simulate ``elapsed`` seconds in whole ticks, keeping the remainder; the frame of the last tick.

        Args:
            elapsed: Seconds to simulate.
            each: Told every tick's frame, as a recorder wants it.

        Raises:
            SimulationError: The physics diverged or an input was refused; ``reset`` makes the session usable again
                after the former, the latter leaves it as it was.
        """
        self._remainder += elapsed
        count = int(self._remainder / self.prepared.scene.tick + 1e-9)
        self._remainder = max(self._remainder - count * self.prepared.scene.tick, 0.0)
        for _ in range(min(count, MAX_TICKS)):
            frame = self.tick()
            if each is not None:
                each(frame)
        return self.frame

    def tick(self) -> Frame:
        """One control tick: inputs, physics, touch, contacts, control."""
        self._take_effect()
        with self._watch.stage("physics"):
            self._simulation.step(self.prepared.scene.steps_per_tick, self._command)
        self._ticks += 1
        self.frame = self._frame()
        return self.frame

    def _take_effect(self) -> None:
        if self.scripted:
            self._waiting += self._stimulus.inputs(self._ticks)
        while self._waiting:
            act = self._waiting.pop(0)
            if isinstance(act, ControlChanged):
                self._controller.settings = act.settings
            elif isinstance(act, MapEdited):
                self.map = act.map
                self._reader.use(self.map)
            else:
                self._simulation.apply(act)
            self.inputs.append((self._ticks + 1, act))

    def _frame(self) -> Frame:
        simulation, watch = self._simulation, self._watch
        with watch.stage("touch"):
            pressures = simulation.sense()
        with watch.stage("contacts"):
            regions = self._reader.read(pressures)
        with watch.stage("control"):
            self._command = self._controller.command(
                simulation.posture, simulation.velocity, regions, self.prepared.scene.tick
            )
        return Frame(
            tick=self._ticks,
            time=self._ticks * self.prepared.scene.tick,
            posture=simulation.posture,
            velocity=simulation.velocity,
            pressures=pressures,
            regions=regions,
            pokes=simulation.pokes,
            command=self._command,
            why_limited=self._controller.why_limited,
            timings=watch.take(),
        )

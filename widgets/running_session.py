"""The session that runs, and what a hand asks of it: touch, control, effects, an edited map, time."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QObject

from app.contacts.reading_settings import ReadingSettings
from app.control.behaviour import Behaviour
from app.control.command import ControlChanged, ControlSettings
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.recording.player import Player
from app.scene.effects import Effects
from app.scene.scene import Scene
from app.session.inputs import BehavioursChanged, EffectsChanged, MapEdited, ReadingChanged, SessionInput
from app.stimuli.from_hand import from_hand
from app.stimuli.stimulus import Stimulus
from app.touch.poke import Finger, PokeMoved, PokePressed, PokeReleased
from widgets.in_force import InForce
from widgets.law_comparison.occasion import Occasion
from widgets.runner import Runner
from widgets.session_facts import SessionFacts

HAND = 1
"""Id of the hand's finger; the scripted ones have 0 and below."""
SCRIPT_SECONDS = 10.0
"""A script is compared on for so long, unless a person says otherwise."""


class RunningSession(SessionFacts):
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
        self.runner: Runner | None = None
        self.player: Player | None = None
        self.finger = Finger()
        self._in_force, self._speed = InForce(self), 1.0
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
    def _running(self) -> Runner | None:
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
            self._in_force.ask(act)
        return running is not None

    def touches(self) -> tuple[Stimulus, ...]:
        """What the hand did since the last reset, as a script; nothing while no session runs."""
        if (running := self._running) is None:
            return ()
        with running.lock:
            session, inputs, tick = running.session, tuple(running.session.inputs), running.session.frame.tick
        prepared = session.prepared
        return from_hand(prepared.skin, inputs, tick=prepared.scene.tick, last=tick)

    def done(self) -> Occasion | None:
        """All that was done since the last reset of what is shown, to compare laws on; None while nothing is."""
        if self.player is not None:
            player = self.player
            return Occasion(player.prepared, tuple(player.inputs), float(player.times[-1]))
        if self.runner is None:
            return None
        with self.runner.lock:
            session = self.runner.session
            return Occasion(session.prepared, tuple(session.inputs), session.frame.time)

    def scripted(self, scene: Scene) -> Occasion | None:
        """The script of ``scene``, as it is simulated now, with the map in force; None while nothing is shown."""
        done, map_ = self.done(), self._shown_map
        if done is None or map_ is None:
            return None
        return Occasion(replace(done.prepared, scene=scene, map=map_), None, SCRIPT_SECONDS)

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

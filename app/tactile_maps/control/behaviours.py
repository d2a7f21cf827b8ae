"""Behaviours: what a contact event changes of what the controller does, and the triggers that wait for such events."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

from tactile_maps.contacts.events import EVENT_KINDS, ContactEvent, EventKind
from tactile_maps.control.controller_registry import check_settings, settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SceneError, did_you_mean
from tactile_maps.core.toml import check_keys
from tactile_maps.skin.model.skin import Skin

SettingValue: TypeAlias = int | float | str | tuple[tuple[float, float], ...]
"""Of the controller: a number, a word, or points on the map [m]."""
ENDING_EVENTS = ("tap", "release")
"""Events that are told only once they are over."""
_MOST_TIMES = 5
_MOST_FORCE = 200.0


@dataclass(frozen=True)
class Behaviour:
    """When this happens, the controller does that.

    Attributes:
        on: The event: when it begins; a tap or release when it is over.
        where: Name of a link or patch; empty for anywhere.
        times: How often it must happen in a row; 2 is a double tap.
        above: Least force of the event [N].
        until_released: Whether the settings from before come back when nothing touches any more.
        then: Settings of the controller that change, by name.

    Raises:
        SceneError: There is no such event or setting, a value is out of range, or nothing would change. Whether such a
            link has skin is checked where the skin is known.
    """

    on: EventKind
    where: str = ""
    times: int = 1
    above: float = 0.0
    until_released: bool = False
    then: Mapping[str, SettingValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.on not in EVENT_KINDS:
            raise _refusal("there is no such event", "on", self.on, did_you_mean(str(self.on), EVENT_KINDS))
        if not isinstance(self.where, str):
            raise _refusal("this must be the name of a link or patch", "where", self.where, "Write it in quotes")
        if type(self.times) is not int or not 1 <= self.times <= _MOST_TIMES:
            raise _refusal(
                "the number of repetitions is out of range", "times", self.times, f"Choose 1 to {_MOST_TIMES}"
            )
        if type(self.above) not in (int, float) or not 0.0 <= self.above <= _MOST_FORCE:
            raise _refusal("the force threshold is out of range", "above", self.above, f"Choose 0 to {_MOST_FORCE:g} N")
        if type(self.until_released) is not bool:
            raise _refusal("this must be true or false", "until_released", self.until_released, "Write true or false")
        if self.until_released and self.on in ENDING_EVENTS:
            remedy = "Leave it out, or choose touch or press"
            raise _refusal(f"a {self.on} has ended when it is reported", "until_released", self.until_released, remedy)
        if not isinstance(self.then, Mapping) or not self.then:
            remedy = 'Write, for example, then = { task = "retreat" }'
            raise _refusal("the behaviour changes no settings", "then", self.then, remedy)
        try:
            settings_from(self.then)
        except SceneError as error:
            key = (error.place or "").removeprefix("control.")
            raise _refusal(error.problem, f"then.{key}", error.value, error.remedy) from error

    @property
    def words(self) -> str:
        """Like "double tap on forearm"."""
        often = {1: "", 2: "double ", 3: "triple "}.get(self.times, f"{self.times} times ")
        place = f" on {self.where.replace('_', ' ')}" if self.where else ""
        return f"{often}{self.on}{place}" + (f" above {self.above:g}\u202fN" if self.above else "")


ControlTrigger: TypeAlias = Behaviour | Literal["released"]
"""Why the controller's settings changed without a person: a behaviour, or the last contact was released, so that those
from before a behaviour came back."""


def trigger_text(trigger: ControlTrigger) -> str:
    """What a person reads of it, like "double tap on forearm" or "released"."""
    return trigger.words if isinstance(trigger, Behaviour) else trigger


def behaviours_from(tables: Sequence[Mapping[str, Any]]) -> tuple[Behaviour, ...]:
    """Behaviours from a scene's tables.

    Raises:
        SceneError: With its place in the scene.
    """
    found = []
    for number, table in enumerate(tables):
        place = f"behaviours.{number}"
        check_keys(table, Behaviour, place=place)
        if "on" not in table:
            raise SceneError("a key is missing", place=place, value="on", remedy='Write on = "tap"')
        try:
            found.append(Behaviour(**table))
        except SceneError as error:
            where = (error.place or "").replace("behaviours", place, 1)
            raise error.at(place=where) from error
    return tuple(found)


def tasks_of(behaviours: Iterable[Behaviour]) -> tuple[str, ...]:
    """The tasks that behaviours may put in force."""
    return tuple(str(behaviour.then["task"]) for behaviour in behaviours if "task" in behaviour.then)


def _refusal(problem: str, key: str, value: object, remedy: str | None) -> SceneError:
    return SceneError(problem, place=f"behaviours.{key}", value=value, remedy=remedy)


WITHIN = 0.8
"""Repeated events count together when they follow each other by no more than this [s]."""


class BehaviourTrigger:
    """Waits for events that trigger behaviours. Mutable; ``reset`` forgets the past.

    Args:
        skin: Whose links and patches they name.
        behaviours: In order; of several that one event triggers, the last has the last word.

    Attributes:
        behaviours: Those waited for.

    Raises:
        SceneError: A behaviour names a link or patch that the skin does not have.

    Cost: nothing at a tick without an event.
    """

    def __init__(self, skin: Skin, behaviours: Sequence[Behaviour]) -> None:
        self._names = [(patch.name, patch.link) for patch in skin.patches]
        self._before: ControlSettings | None = None
        self.use(behaviours)

    def use(self, behaviours: Sequence[Behaviour]) -> None:
        """Wait for other events; what comes back at a release still does. Raises SceneError, and keeps the old ones."""
        known = sorted({name for both in self._names for name in both})
        for number, behaviour in enumerate(behaviours):
            if behaviour.where and behaviour.where not in known:
                remedy = did_you_mean(behaviour.where, tuple(known))
                place = f"behaviours.{number}.where"
                problem = "no such link or patch has skin"
                raise SceneError(problem, place=place, value=behaviour.where, remedy=remedy)
        self.behaviours = tuple(behaviours)
        self._past: dict[int, deque[float]] = {}

    def reset(self) -> ControlSettings | None:
        """Nothing has happened; the settings that are to come back from what held until a release, None for none."""
        before = self._before
        self._before = None
        self._past.clear()
        return before

    def settled(self) -> None:
        """A person has chosen settings: what would come back is forgotten."""
        self._before = None

    def triggered(
        self, events: Sequence[ContactEvent], settings: ControlSettings, *, touched: bool
    ) -> tuple[ControlSettings, ControlTrigger] | None:
        """Other settings, and why; None while nothing is triggered.

        Args:
            events: Of one tick.
            settings: In force.
            touched: Whether any contact has not been released yet. One that a slow skin missed in a sample has not.
        """
        now = settings
        why: ControlTrigger | None = None
        for event in events:
            for number, behaviour in enumerate(self.behaviours):
                if self._happened(number, behaviour, event):
                    if behaviour.until_released and self._before is None:
                        self._before = settings
                    now = _changed(now, behaviour)
                    why = behaviour
        if not touched and self._before is not None and why is None:
            now = self._before
            why = "released"
        if not touched:
            self._before = None
        return (now, why) if why is not None and now != settings else None

    def _happened(self, number: int, behaviour: Behaviour, event: ContactEvent) -> bool:
        told = "ended" if event.kind in ENDING_EVENTS else "began"
        if event.kind != behaviour.on or event.phase != told or (event.force or 0.0) < behaviour.above:
            return False
        if behaviour.where and behaviour.where not in (*self._names[event.at.patch], *event.links):
            return False
        past = self._past.setdefault(number, deque(maxlen=behaviour.times))
        if past and event.time - past[-1] > WITHIN:
            past.clear()
        past.append(event.time)
        if len(past) < behaviour.times:
            return False
        past.clear()
        return True


def _changed(settings: ControlSettings, behaviour: Behaviour) -> ControlSettings:
    changes: dict[str, Any] = dict(behaviour.then)
    return check_settings(replace(settings, **changes))

"""Behaviours: changes of controller settings that contact events trigger."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypeAlias

from tactile_maps.contacts.events import EVENT_KINDS, ContactEvent, EventKind
from tactile_maps.control.controller_registry import check_settings, settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SceneError, did_you_mean
from tactile_maps.core.toml import check_keys
from tactile_maps.skin.model.skin import Skin

SettingValue: TypeAlias = int | float | str | tuple[tuple[float, float], ...]
"""Value of a controller setting: a number, a word, or points on the map [m]."""
ENDING_EVENTS = ("tap", "release")
"""Events that are reported only when they have ended."""
_MOST_TIMES = 5
_MOST_FORCE = 200.0


@dataclass(frozen=True)
class Behaviour:
    """Change of settings when a contact event occurs.

    Attributes:
        on: Kind of event. It counts when it begins; a tap or release when it has ended.
        where: Name of a link or patch; empty for anywhere.
        times: Number of repetitions; 2 is a double tap.
        above: Smallest force of the event [N].
        until_released: Whether the previous settings return when nothing touches any more.
        then: New values of controller settings, by name.

    Raises:
        SceneError: The event or setting is unknown, a value is out of range, or ``then`` is empty. ``BehaviourTrigger``
            checks the names of links and patches.
    """

    on: EventKind
    where: str = ""
    times: int = 1
    above: float = 0.0
    until_released: bool = False
    then: Mapping[str, SettingValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        repeats = type(self.times) is int and 1 <= self.times <= _MOST_TIMES
        threshold = type(self.above) in (int, float) and 0.0 <= self.above <= _MOST_FORCE
        lasts = not self.until_released or self.on not in ENDING_EVENTS
        changes = isinstance(self.then, Mapping) and bool(self.then)
        known = did_you_mean(str(self.on), EVENT_KINDS)
        for name, valid, problem, remedy in (
            ("on", self.on in EVENT_KINDS, "unknown event", known),
            ("where", isinstance(self.where, str), "this must be the name of a link or patch", "Write it in quotes"),
            ("times", repeats, "the number of repetitions is out of range", f"Choose 1 to {_MOST_TIMES}"),
            ("above", threshold, "the force threshold is out of range", f"Choose 0 to {_MOST_FORCE:g} N"),
            (
                "until_released",
                type(self.until_released) is bool,
                "this must be true or false",
                "Write true or false",
            ),
            (
                "until_released",
                lasts,
                f"a {self.on} has ended when it is reported",
                "Leave it out, or choose touch or press",
            ),
            ("then", changes, "the behaviour changes no settings", 'Write, for example, then = { task = "retreat" }'),
        ):
            if not valid:
                raise SceneError(problem, place=f"behaviours.{name}", value=getattr(self, name), remedy=remedy)
        try:
            settings_from(self.then)
        except SceneError as error:
            key = (error.place or "").removeprefix("control.")
            raise error.at(place=f"behaviours.then.{key}") from error

    @property
    def words(self) -> str:
        """Description like "double tap on forearm"."""
        often = {1: "", 2: "double ", 3: "triple "}.get(self.times, f"{self.times} times ")
        place = f" on {self.where.replace('_', ' ')}" if self.where else ""
        return f"{often}{self.on}{place}" + (f" above {self.above:g}\u202fN" if self.above else "")


ControlTrigger: TypeAlias = Behaviour | Literal["released"]
"""Reason why settings changed without user action: a behaviour, or the release of the last contact, which restored the
settings from before a behaviour."""


def trigger_text(trigger: ControlTrigger) -> str:
    """Return the reason as text, like "double tap on forearm" or "released"."""
    return trigger.words if isinstance(trigger, Behaviour) else trigger


def behaviours_from(tables: Sequence[Mapping[str, Any]]) -> tuple[Behaviour, ...]:
    """Read behaviours from a scene's tables.

    Raises:
        SceneError: A table is invalid; the error names its place in the scene.
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


def behaviours_to(behaviours: Iterable[Behaviour]) -> tuple[dict[str, Any], ...]:
    """Return the tables from which ``behaviours_from`` reads these behaviours."""
    return tuple(
        {field.name: getattr(one, field.name) for field in fields(one) if getattr(one, field.name) != field.default}
        for one in behaviours
    )


def tasks_of(behaviours: Iterable[Behaviour]) -> tuple[str, ...]:
    """Return the tasks that behaviours may activate."""
    return tuple(str(behaviour.then["task"]) for behaviour in behaviours if "task" in behaviour.then)


WITHIN = 0.8
"""Longest time between repeated events that count together [s]."""


class BehaviourTrigger:
    """Detects events that trigger behaviours. Mutable; ``reset`` discards the past.

    Args:
        skin: Skin with the named links and patches.
        behaviours: Behaviours in order; if one event triggers several, the last has precedence.

    Attributes:
        behaviours: Active behaviours.

    Raises:
        SceneError: A behaviour names a link or patch that the skin does not have.

    Cost: none at a tick without an event.
    """

    def __init__(self, skin: Skin, behaviours: Sequence[Behaviour]) -> None:
        self._names = [(patch.name, patch.link) for patch in skin.patches]
        self._before: ControlSettings | None = None
        self.use(behaviours)

    def use(self, behaviours: Sequence[Behaviour]) -> None:
        """Replace the behaviours; settings to be restored at a release are kept. On SceneError the old ones stay."""
        known = sorted({name for both in self._names for name in both})
        for number, behaviour in enumerate(behaviours):
            where = behaviour.where
            if where and where not in known:
                remedy = did_you_mean(where, tuple(known))
                place = f"behaviours.{number}.where"
                raise SceneError("no such link or patch has skin", place=place, value=where, remedy=remedy)
        self.behaviours = tuple(behaviours)
        self._past: dict[int, deque[float]] = {}

    def reset(self) -> ControlSettings | None:
        """Discard all events; return the settings that were to be restored at a release, or None."""
        before = self._before
        self._before = None
        self._past.clear()
        return before

    def settled(self) -> None:
        """Discard the settings to be restored, because the user has chosen settings."""
        self._before = None

    def triggered(
        self, events: Sequence[ContactEvent], settings: ControlSettings, *, touched: bool
    ) -> tuple[ControlSettings, ControlTrigger] | None:
        """Return new settings and the reason; None if nothing is triggered.

        Args:
            events: Events of one tick.
            settings: Current settings.
            touched: Whether any contact has not been released yet. A contact that a slow skin missed in one sample has
                not.
        """
        now = settings
        why: ControlTrigger | None = None
        for event in events:
            for number, behaviour in enumerate(self.behaviours):
                if self._happened(number, behaviour, event):
                    if behaviour.until_released and self._before is None:
                        self._before = settings
                    changes: dict[str, Any] = dict(behaviour.then)
                    now = check_settings(replace(now, **changes))
                    why = behaviour
        if not touched and self._before is not None and why is None:
            now = self._before
            why = "released"
        if not touched:
            self._before = None
        return (now, why) if why is not None and now != settings else None

    def _happened(self, number: int, behaviour: Behaviour, event: ContactEvent) -> bool:
        phase = "ended" if event.kind in ENDING_EVENTS else "began"
        if event.kind != behaviour.on or event.phase != phase or (event.force or 0.0) < behaviour.above:
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

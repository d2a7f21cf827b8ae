"""Behaviours: what a contact event changes of what the controller does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from app.contacts.event import EVENT_KINDS, EventKind
from app.control.settings_check import settings_from
from app.errors import SceneError
from app.toml.nearest import nearest

TOLD_LATE = ("tap", "release")
"""Events that are told only once they are over."""
_MOST_TIMES, _MOST_FORCE = 5, 200.0


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
            link wears skin is checked where the skin is known.
    """

    on: EventKind
    where: str = ""
    times: int = 1
    above: float = 0.0
    until_released: bool = False
    then: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.on not in EVENT_KINDS:
            raise _refusal("there is no such event", "on", self.on, nearest(str(self.on), EVENT_KINDS))
        if not isinstance(self.where, str):
            raise _refusal("this must be the name of a link or patch", "where", self.where, "Write it in quotes")
        if type(self.times) is not int or not 1 <= self.times <= _MOST_TIMES:
            raise _refusal("that is no number of times", "times", self.times, f"Choose 1 to {_MOST_TIMES}")
        if type(self.above) not in (int, float) or not 0.0 <= self.above <= _MOST_FORCE:
            raise _refusal("that is no force to wait for", "above", self.above, f"Choose 0 to {_MOST_FORCE:g} N")
        if type(self.until_released) is not bool:
            raise _refusal("this must be true or false", "until_released", self.until_released, "Write true or false")
        if self.until_released and self.on in TOLD_LATE:
            remedy = "Leave it out, or choose touch or press"
            raise _refusal(f"a {self.on} is over when it is told", "until_released", self.until_released, remedy)
        if not isinstance(self.then, Mapping) or not self.then:
            remedy = 'Write, for example, then = { task = "retreat" }'
            raise _refusal("it changes no settings", "then", self.then, remedy)
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
        return f"{often}{self.on}{place}" + (f" above {self.above:g}\u2009N" if self.above else "")


def behaviours_from(tables: Sequence[Mapping[str, Any]]) -> tuple[Behaviour, ...]:
    """Behaviours from a scene's tables.

    Raises:
        SceneError: With its place in the scene.
    """
    known = tuple(field.name for field in fields(Behaviour))
    found = []
    for number, table in enumerate(tables):
        place = f"behaviours.{number}"
        for key in table:
            if key not in known:
                raise SceneError("there is no such key", place=f"{place}.{key}", value=key, remedy=nearest(key, known))
        if "on" not in table:
            raise SceneError("a key is missing", place=place, value="on", remedy='Write on = "tap"')
        try:
            found.append(Behaviour(**table))
        except SceneError as error:
            where = (error.place or "").replace("behaviours", place, 1)
            raise SceneError(error.problem, place=where, value=error.value, remedy=error.remedy) from error
    return tuple(found)


def _refusal(problem: str, key: str, value: object, remedy: str | None) -> SceneError:
    return SceneError(problem, place=f"behaviours.{key}", value=value, remedy=remedy)

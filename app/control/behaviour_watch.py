"""Contact events as triggers: waits for those that a behaviour names, and answers with other settings."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from app.contacts.event import ContactEvent
from app.control.behaviour import TOLD_LATE, Behaviour
from app.control.command import ControlSettings
from app.control.settings_check import check_settings
from app.errors import SceneError
from app.skin.skin import Skin
from app.toml.nearest import nearest

WITHIN = 0.8
"""Repeated events count together when they follow each other by no more than this [s]."""


class BehaviourWatch:
    """Waits for events that trigger behaviours. Mutable; ``reset`` forgets the past.

    Args:
        behaviours: In order; of several that one event triggers, the last has the last word.
        skin: Whose links and patches they name.

    Attributes:
        behaviours: Those waited for.

    Raises:
        SceneError: A behaviour names a link or patch that the skin does not have.

    Cost: nothing at a tick without an event.
    """

    def __init__(self, behaviours: Sequence[Behaviour], skin: Skin) -> None:
        self._names = [(patch.name, patch.link) for patch in skin.patches]
        self.use(behaviours)
        self.reset()

    def use(self, behaviours: Sequence[Behaviour]) -> None:
        """Wait for other events; what comes back at a release still does. Raises SceneError, and keeps the old ones."""
        known = sorted({name for both in self._names for name in both})
        for number, behaviour in enumerate(behaviours):
            if behaviour.where and behaviour.where not in known:
                remedy = nearest(behaviour.where, tuple(known))
                place, problem = f"behaviours.{number}.where", "no such link or patch wears skin"
                raise SceneError(problem, place=place, value=behaviour.where, remedy=remedy)
        self.behaviours = tuple(behaviours)
        self._past: dict[int, deque[float]] = {}

    def reset(self) -> None:
        """Nothing has happened."""
        self._past.clear()
        self._before: ControlSettings | None = None

    def settled(self) -> None:
        """A person has chosen settings: what would come back is forgotten."""
        self._before = None

    def triggered(
        self, events: Sequence[ContactEvent], settings: ControlSettings, *, touched: bool
    ) -> tuple[ControlSettings, str] | None:
        """Other settings, with the words that say why; None while nothing is triggered.

        Args:
            events: Of one tick.
            settings: In force.
            touched: Whether anything still touches.
        """
        now, why = settings, ""
        for event in events:
            for number, behaviour in enumerate(self.behaviours):
                if self._happened(number, behaviour, event):
                    if behaviour.until_released and self._before is None:
                        self._before = settings
                    now, why = _changed(now, behaviour), behaviour.words
        if not touched and self._before is not None and not why:
            now, why = self._before, "released"
        if not touched:
            self._before = None
        return (now, why) if now != settings else None

    def _happened(self, number: int, behaviour: Behaviour, event: ContactEvent) -> bool:
        told = "ended" if event.kind in TOLD_LATE else "began"
        if event.kind != behaviour.on or event.phase != told or event.force < behaviour.above:
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

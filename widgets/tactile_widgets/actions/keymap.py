"""Which keys ask for which action: those of the table, and what a person has changed of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

Keys = tuple[str, ...]

RESERVED: Mapping[str, str] = {
    **dict.fromkeys(("Esc", "Return", "Enter"), "the gesture that is going on, and dialogs"),
    **dict.fromkeys(("Tab", "Shift+Tab", "Backtab", "Shift+Backtab"), "going from control to control"),
    **dict.fromkeys(("Up", "Down", "Left", "Right"), "moving the map, the selection and the step in time"),
    **dict.fromkeys(("PgUp", "PgDown", "Del"), "the tool that is in use"),
}
"""Keys, as Qt writes them, that no action can have, and whose they are."""


@dataclass(frozen=True)
class KeyMap:
    """The keys of actions. Each key belongs to one action at most.

    Attributes:
        defaults: The keys of each action as it ships, in the order of the menus.
        changes: Those that a person chose instead; no key at all is a choice too. A default key that was given to
            another action is no longer its own.
    """

    defaults: Mapping[str, Keys]
    changes: Mapping[str, Keys] = field(default_factory=dict)

    @cached_property
    def _owners(self) -> dict[str, str]:
        """The action of each key: what was chosen comes before what ships."""
        owners: dict[str, str] = {}
        chosen = {name: keys for name, keys in self.changes.items() if name in self.defaults}
        shipped = {name: keys for name, keys in self.defaults.items() if name not in chosen}
        for name, keys in (*chosen.items(), *shipped.items()):
            for key in keys:
                owners.setdefault(key, name)
        return owners

    def keys(self, name: str) -> Keys:
        """All keys of an action; the first is the one that is shown."""
        own = self.changes.get(name, self.defaults[name])
        return tuple(key for key in own if self._owners[key] == name)

    def owner(self, key: str) -> str | None:
        """The name of the action that a key asks for; None where it asks for none."""
        return self._owners.get(key)

    def changed(self, name: str) -> bool:
        """Whether an action has other keys than it ships with."""
        return self.keys(name) != self.defaults[name]

    def conflicts(self, name: str, keys: Sequence[str]) -> dict[str, str]:
        """The keys among ``keys`` that other actions than ``name`` have, with these actions."""
        return {key: owner for key in keys if (owner := self.owner(key)) not in (None, name)}

    def with_keys(self, name: str, keys: Keys) -> KeyMap:
        """The same with other keys for an action; one that is left without a key by that gets what ``name`` gave up."""
        before = self.keys(name)
        chosen = {**self.changes, name: keys}
        spare = [key for key in before if key not in keys]
        for owner in dict.fromkeys(self.conflicts(name, keys).values()):
            left = tuple(key for key in self.keys(owner) if key not in keys)
            chosen[owner] = left or tuple(spare[:1])
            spare = spare if left else spare[1:]
        return replace(self, changes=_without_defaults(chosen, self.defaults))


def _without_defaults(changes: Mapping[str, Keys], defaults: Mapping[str, Keys]) -> dict[str, Keys]:
    return {name: keys for name, keys in changes.items() if keys != defaults.get(name)}

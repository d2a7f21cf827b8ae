"""Shortcuts of actions: the defaults of the table and the changes of the user."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

Keys = tuple[str, ...]

RESERVED: Mapping[str, str] = {
    **dict.fromkeys(("Esc", "Return", "Enter"), "the current gesture, and dialogs"),
    **dict.fromkeys(("Tab", "Shift+Tab", "Backtab", "Shift+Backtab"), "moving between controls"),
    **dict.fromkeys(("Up", "Down", "Left", "Right"), "moving the map or the selection, and stepping in time"),
    **dict.fromkeys(("PgUp", "PgDown", "Del"), "the current tool"),
}
"""Keys in Qt's notation that cannot be shortcuts, each with its use."""


@dataclass(frozen=True)
class KeyMap:
    """Shortcuts of actions. Each key belongs to at most one action.

    Attributes:
        defaults: Default keys of each action, in the order of the menus.
        changes: Keys chosen by the user for some actions; may be none. A default key that the user gave to another
            action no longer belongs to the first one.
    """

    defaults: Mapping[str, Keys]
    changes: Mapping[str, Keys] = field(default_factory=dict)

    @cached_property
    def _owners(self) -> dict[str, str]:
        """Action of each key; the user's choices come before the defaults."""
        owners: dict[str, str] = {}
        chosen = {name: keys for name, keys in self.changes.items() if name in self.defaults}
        shipped = {name: keys for name, keys in self.defaults.items() if name not in chosen}
        for name, keys in (*chosen.items(), *shipped.items()):
            for key in keys:
                owners.setdefault(key, name)
        return owners

    def keys(self, name: str) -> Keys:
        """Return the keys of an action; the first is displayed."""
        own = self.changes.get(name, self.defaults[name])
        return tuple(key for key in own if self._owners[key] == name)

    def owner(self, key: str) -> str | None:
        """Return the name of the action of a key, or None."""
        return self._owners.get(key)

    def changed(self, name: str) -> bool:
        """Whether the keys of an action differ from its defaults."""
        return self.keys(name) != self.defaults[name]

    def conflicts(self, name: str, keys: Sequence[str]) -> dict[str, str]:
        """Return the keys among ``keys`` that belong to actions other than ``name``, each with its action."""
        return {key: owner for key in keys if (owner := self.owner(key)) not in (None, name)}

    def with_keys(self, name: str, keys: Keys) -> KeyMap:
        """Return a copy with other keys for an action; an action that loses its only key gets the freed one."""
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

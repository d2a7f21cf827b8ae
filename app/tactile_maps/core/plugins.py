"""Plug-ins: what other installed packages add to the registries of this program, by entry points.

A package states in its metadata, in the group ``tactile_maps.KIND``, a name and the object behind it: the same frozen
entry that the registry of that kind is made of. A ``Registry`` holds the built-in entries and finds those of plug-ins
when a name that is not built in is asked for, or all names are: nothing of a plug-in is imported before. What is found
is checked at this door; one that cannot be used is left out and remembered with the reason (``Registry.plugins``), and
never stops the program. What a plug-in raises at work becomes a ``PluginError`` that names it.

Only what is installed in the environment is found: no file, scene or recording can name code.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, Protocol, TypeVar

from tactile_maps.core.errors import Finding, PluginError, TactileMapsError, did_you_mean

PREFIX = "tactile_maps."
"""Of the groups of entry points."""
_NAME = re.compile("[a-z][a-z0-9]*([-_][a-z0-9]+)*")


@dataclass(frozen=True)
class Plugin:
    """One entry point of another package.

    Attributes:
        kind: What it adds, the end of its group, as ``map_methods``.
        name: What it is called in choices.
        package: That states it, as ``pip`` calls it.
        version: Of the package.
        target: Module and object, as the entry point says.
        problem: Why it is left out; None where it is in use.
    """

    kind: str
    name: str
    package: str
    version: str
    target: str
    problem: str | None = None

    @property
    def finding(self) -> Finding:
        """That it was left out, why, and what to do."""
        action = f"left out: {self.problem}. Update it, or pip uninstall {self.package}"
        return Finding("broken-plug-in", f"{self.package} {self.version}, {self.kind}, {self.name}", action)

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """What the plug-in raises inside, and is no error of ours, becomes one that names it.

        Raises:
            PluginError: The plug-in failed.
        """
        try:
            yield
        except TactileMapsError:
            raise
        except Exception as error:
            raise self.error(f"it failed with {type(error).__name__}", str(error)) from error

    def error(self, problem: str, value: object = None) -> PluginError:
        """A failure of this plug-in at work."""
        place = f"plug-in {self.name} of {self.package} {self.version}"
        remedy = f"Choose another, update the package, or pip uninstall {self.package}"
        return PluginError(problem, place=place, value=value, remedy=remedy)


class Entry(Protocol):
    """What registries are made of."""

    @property
    def name(self) -> str:
        """In choices."""


T = TypeVar("T", bound=Entry)
_registries: list[Registry[Any]] = []
"""Every registry that has been imported, in that order."""


class Registry(Mapping[str, T], Generic[T]):
    """Entries by name: the built-in ones in their order, then those of plug-ins by name. Mutable: it remembers.

    Asking for a built-in name looks for no plug-in; asking for another imports the one of that name; iterating imports
    all of the kind. Cost of the first such question: reading the metadata of what is installed, once for all kinds.

    Args:
        kind: Of the plug-ins, the end of their group.
        entry: The class of the entries.
        built_in: Those of this program.
        guard: The entry that is used for a plug-in's: the same, with its calls checked and its errors named. It may
            raise a ``PluginError`` for one that cannot be used.
        reserved: Further names that no plug-in may have.
    """

    def __init__(
        self, kind: str, entry: type[T], built_in: Iterable[T], guard: Callable[[Plugin, T], T],
        *, reserved: Iterable[str] = (),
    ) -> None:  # fmt: skip
        self.kind = kind
        self._entry = entry
        self._guard = guard
        self._built_in = {one.name: one for one in built_in}
        self._taken = {*self._built_in, *reserved}
        self._loaded: dict[tuple[EntryPoint, str, bool], tuple[Plugin, T | None]] = {}
        _registries.append(self)

    @property
    def built_in(self) -> tuple[str, ...]:
        """Names of those of this program."""
        return tuple(self._built_in)

    def __getitem__(self, name: str) -> T:
        if name in self._built_in:
            return self._built_in[name]
        for _, entry in self._load(name):
            if entry is not None:
                return entry
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        yield from self._built_in
        yield from sorted(plugin.name for plugin, entry in self._load() if entry is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def plugins(self) -> tuple[Plugin, ...]:
        """All of this kind that are installed, in use or left out, by name; they are imported for the answer."""
        return tuple(plugin for plugin, _ in self._load())

    def known_problems(self) -> tuple[Plugin, ...]:
        """Those that were left out so far; nothing is imported for the answer."""
        here = (self._loaded.get(self._key(point)) for point in _found(self.kind))
        return tuple(loaded[0] for loaded in here if loaded is not None and loaded[0].problem is not None)

    def remedy(self, name: str) -> str:
        """What to do about a name that is none: the nearest, all there are, and why a plug-in of the name is not."""
        for plugin, _ in self._load(name):
            if plugin.problem is not None:
                return f"The plug-in of {plugin.package} that adds it was left out: {plugin.problem}"
        return f"{did_you_mean(name, tuple(self))}, or install the plug-in that adds it"

    def _load(self, name: str | None = None) -> list[tuple[Plugin, T | None]]:
        return [self._checked(point) for point in _found(self.kind) if name is None or point.name == name]

    def _checked(self, point: EntryPoint) -> tuple[Plugin, T | None]:
        plugin = _described(point, self.kind)
        key = self._key(point)
        if key not in self._loaded:
            try:
                self._loaded[key] = plugin, self._guard(plugin, self._entry_of(plugin, point))
            except (Exception, SystemExit) as error:  # whatever the import of strangers' code does, we go on
                problem = error.problem if isinstance(error, PluginError) else f"{type(error).__name__}: {error}"
                self._loaded[key] = replace(plugin, problem=problem), None
        return self._loaded[key]

    def _key(self, point: EntryPoint) -> tuple[EntryPoint, str, bool]:
        """By which it is remembered: what it is, whose, and whether it alone has its name."""
        alone = sum(other.name == point.name for other in _found(self.kind)) == 1
        return point, _described(point, self.kind).package, alone

    def _entry_of(self, plugin: Plugin, point: EntryPoint) -> T:
        if not _NAME.fullmatch(plugin.name):
            raise plugin.error("its name is not of small letters, digits and hyphens")
        if plugin.name in self._taken:
            raise plugin.error("its name is that of a built-in one")
        if not self._key(point)[-1]:
            raise plugin.error("two packages have plug-ins of this name")
        found = point.load()
        if not isinstance(found, self._entry):
            raise plugin.error(f"{point.value} is no {self._entry.__name__} but a {type(found).__name__}")
        if found.name != plugin.name:
            raise plugin.error(f"its entry point and its entry disagree on its name, {found.name}")
        return found


def check_call(plugin: Plugin, function: object, *arguments: str) -> None:
    """Refuse what cannot be called with so many ``arguments``, named as the documentation does.

    Raises:
        PluginError: It cannot.
    """
    words = ", ".join(arguments)
    if not callable(function):
        raise plugin.error(f"what should be called with ({words}) cannot be called")
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError as error:
        raise plugin.error(f"its function does not take ({words}): {error}") from error
    except ValueError:
        return  # compiled functions tell no signature


def check_members(plugin: Plugin, value: object, *members: str) -> None:
    """Refuse an object without the ``members`` of its protocol.

    Raises:
        PluginError: One is missing.
    """
    missing = [name for name in members if not hasattr(value, name)]
    if missing:
        raise plugin.error(f"its {type(value).__name__} has no {', '.join(missing)}")


def has_plugins(kind: str) -> bool:
    """Whether any are installed; nothing is imported for the answer."""
    return bool(_found(kind))


def _found(kind: str) -> tuple[EntryPoint, ...]:
    return _all_found(tuple(sys.path)).get(kind, ())


@lru_cache(maxsize=4)
def _all_found(_path: tuple[str, ...]) -> dict[str, tuple[EntryPoint, ...]]:
    """Entry points of all kinds, by kind, in the order of their names; read anew where the path has changed."""
    every = entry_points()
    return {
        group.removeprefix(PREFIX): tuple(sorted(set(every.select(group=group)), key=lambda one: (one.name, one.value)))
        for group in every.groups
        if group.startswith(PREFIX)
    }


def broken_plugins() -> tuple[Plugin, ...]:
    """All plug-ins that were left out so far, of every kind; nothing is imported for the answer."""
    return tuple(plugin for registry in _registries for plugin in registry.known_problems())


def unknown_kinds(known: Sequence[str]) -> tuple[Plugin, ...]:
    """Plug-ins of groups that are none of the ``known`` kinds, as by a slip of the pen or for another version."""
    return tuple(
        _described(point, kind, f"there is no kind {kind}. {did_you_mean(kind, tuple(known))}")
        for kind, points in sorted(_all_found(tuple(sys.path)).items())
        if kind not in known
        for point in points
    )


def _described(point: EntryPoint, kind: str, problem: str | None = None) -> Plugin:
    package, version = (point.dist.name, point.dist.version) if point.dist is not None else ("?", "?")
    return Plugin(kind, point.name, package, version, point.value, problem)

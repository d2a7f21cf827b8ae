"""Plug-ins: entries that other installed packages add to the registries of this program by entry points.

The metadata of a package states, in the group ``tactile_maps.KIND``, a name and an object: a frozen entry of the class
that the registry of that kind contains. A ``Registry`` contains the built-in entries. It imports plug-ins only when a
name that is not built in, or the list of all names, is requested. Entries are checked when they are loaded; an invalid
one is omitted and kept with the reason (``Registry.plugins``), and never stops the program. ``guard_call`` and
``PluginObject`` turn exceptions of a plug-in into a ``PluginError`` that names it, and check its results.

Only packages that are installed in the environment are found: no file, scene or recording can name code.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar

from tactile_maps.core.errors import Finding, PluginError, TactileMapsError, did_you_mean

PREFIX = "tactile_maps."
"""Prefix of the groups of entry points."""
_NAME = re.compile("[a-z][a-z0-9]*([-_][a-z0-9]+)*")


@dataclass(frozen=True)
class Plugin:
    """Entry point of another package.

    Attributes:
        kind: Kind of entry, the end of its group, such as ``map_methods``.
        name: Name in choices.
        package: Name of the package for ``pip``.
        version: Version of the package.
        target: Module and object that the entry point names.
        problem: Reason for omitting it; None if it is in use.
    """

    kind: str
    name: str
    package: str
    version: str
    target: str
    problem: str | None = None

    @property
    def finding(self) -> Finding:
        """Finding that the plug-in was omitted, with the reason and the remedy."""
        action = f"left out: {self.problem}. Update it, or pip uninstall {self.package}"
        return Finding("broken-plug-in", f"{self.package} {self.version}, {self.kind}, {self.name}", action)

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Turn an exception of the plug-in inside the block into an error that names the plug-in.

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
        """Return an error that names this plug-in."""
        place = f"plug-in {self.name} of {self.package} {self.version}"
        remedy = f"Choose another, update the package, or pip uninstall {self.package}"
        return PluginError(problem, place=place, value=value, remedy=remedy)


class Entry(Protocol):
    """Entry of a registry."""

    @property
    def name(self) -> str:
        """Name in choices."""


T = TypeVar("T", bound=Entry)
_registries: list[Registry[Any]] = []
"""All imported registries, in the order of import."""


class Registry(Mapping[str, T], Generic[T]):
    """Entries by name: the built-in ones in their order, then plug-ins by name. Mutable: loaded plug-ins are kept.

    Access to a built-in name does not look for plug-ins; access to another name imports the plug-in of that name;
    iteration imports all of the kind. Cost of the first such access: reading the metadata of all installed packages,
    once for all kinds.

    Args:
        kind: Kind of the plug-ins, the end of their group.
        entry: Class of the entries.
        built_in: Entries of this program.
        guard: Returns the entry to use for a plug-in: the same with its calls checked and its errors named. It raises a
            ``PluginError`` for an invalid entry.
        reserved: Further names that plug-ins may not use.
    """

    def __init__(
        self,
        kind: str,
        entry: type[T],
        built_in: Iterable[T],
        guard: Callable[[Plugin, T], T],
        *,
        reserved: Iterable[str] = (),
    ) -> None:
        self.kind = kind
        self._entry = entry
        self._guard = guard
        self._built_in = {one.name: one for one in built_in}
        self._taken = {*self._built_in, *reserved}
        self._loaded: dict[tuple[EntryPoint, str, bool], tuple[Plugin, T | None]] = {}
        _registries.append(self)

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
        """Return all installed plug-ins of this kind, in use or omitted, by name; imports them."""
        return tuple(plugin for plugin, _ in self._load())

    def known_problems(self) -> tuple[Plugin, ...]:
        """Return the plug-ins that were omitted so far; imports nothing."""
        here = (self._loaded.get(self._key(point)) for point in _found(self.kind))
        return tuple(loaded[0] for loaded in here if loaded is not None and loaded[0].problem is not None)

    def remedy(self, name: str) -> str:
        """Return the remedy for an unknown name: similar names, or why a plug-in of that name was omitted."""
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
            except (Exception, SystemExit) as error:  # whatever a plug-in raises, the program continues
                problem = error.problem if isinstance(error, PluginError) else f"{type(error).__name__}: {error}"
                self._loaded[key] = replace(plugin, problem=problem), None
        return self._loaded[key]

    def _key(self, point: EntryPoint) -> tuple[EntryPoint, str, bool]:
        """Return the key of the cache: the entry point, its package, and whether no other one has its name."""
        alone = sum(other.name == point.name for other in _found(self.kind)) == 1
        return point, _described(point, self.kind).package, alone

    def _entry_of(self, plugin: Plugin, point: EntryPoint) -> T:
        if not _NAME.fullmatch(plugin.name):
            raise plugin.error("its name must consist of lower-case letters, digits and hyphens")
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


def guard_call(
    plugin: Plugin, function: Callable[..., Any], *arguments: str, check: Callable[..., Any] | None = None
) -> Callable[..., Any]:
    """Return the function of a plug-in with its errors named and its results checked.

    Args:
        plugin: Plug-in that defines the function.
        function: The function.
        arguments: Names of its positional arguments, as the documentation gives them.
        check: Called instead, with the function and its arguments; returns the result or raises a ``PluginError``.

    Raises:
        PluginError: The function cannot be called with these arguments.
    """
    words = ", ".join(arguments)
    if not callable(function):
        raise plugin.error(f"what should be called with ({words}) cannot be called")
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError as error:
        raise plugin.error(f"its function does not take ({words}): {error}") from error
    except ValueError:
        pass  # compiled functions have no signature

    def guarded(*values: Any, **named: Any) -> Any:
        with plugin.at_work():
            return function(*values, **named) if check is None else check(function, *values, **named)

    return guarded


class PluginObject:
    """An object created by a plug-in; its errors name the plug-in, and its results are checked.

    Args:
        plugin: Plug-in that created the object.
        value: The object.
        members: Attributes that its protocol requires.
        checks: By method, a function that is called instead, with the method and its arguments; it returns the result
            or raises a ``PluginError``. By attribute, a function that converts it.
        defaults: Optional attributes, as functions of the object, for objects without them.
        kind: Kind of the errors.

    Raises:
        PluginError: A required attribute is missing.
    """

    def __init__(
        self,
        plugin: Plugin,
        value: Any,
        *members: str,
        checks: Mapping[str, Callable[..., Any]] = MappingProxyType({}),
        defaults: Mapping[str, Callable[[Any], Any]] = MappingProxyType({}),
        kind: type[TactileMapsError] = PluginError,
    ) -> None:
        missing = [name for name in members if not hasattr(value, name)]
        if missing:
            raise plugin.error(f"its {type(value).__name__} has no {', '.join(missing)}")
        self.__dict__.update(_plugin=plugin, _value=value, _checks=checks, _defaults=defaults, _kind=kind)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # while the object is copied or unpickled
            raise AttributeError(name)
        with self._named():
            if name in self._defaults and not hasattr(self._value, name):
                found = self._defaults[name](self._value)
            else:
                found = getattr(self._value, name)
        check = self._checks.get(name)
        if callable(found):
            return partial(self._call, found, check)
        return found if check is None else check(found)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._value, name, value)

    def _call(self, method: Callable[..., Any], check: Callable[..., Any] | None, *values: Any, **named: Any) -> Any:
        with self._named():
            return method(*values, **named) if check is None else check(method, *values, **named)

    @contextmanager
    def _named(self) -> Iterator[None]:
        try:
            with self._plugin.at_work():
                yield
        except PluginError as error:
            if self._kind is PluginError:
                raise
            raise error.at(kind=self._kind) from error


def has_plugins(kind: str) -> bool:
    """Whether any are installed; imports nothing."""
    return bool(_found(kind))


def _found(kind: str) -> tuple[EntryPoint, ...]:
    return _all_found(tuple(sys.path)).get(kind, ())


@lru_cache(maxsize=4)
def _all_found(_path: tuple[str, ...]) -> dict[str, tuple[EntryPoint, ...]]:
    """Return the entry points by kind, in the order of their names; ``_path`` is the key of the cache."""
    every = entry_points()
    return {
        group.removeprefix(PREFIX): tuple(sorted(set(every.select(group=group)), key=lambda one: (one.name, one.value)))
        for group in every.groups
        if group.startswith(PREFIX)
    }


def broken_plugins() -> tuple[Plugin, ...]:
    """Return the plug-ins of all kinds that were omitted so far; imports nothing."""
    return tuple(plugin for registry in _registries for plugin in registry.known_problems())


def unknown_kinds(known: Sequence[str]) -> tuple[Plugin, ...]:
    """Return plug-ins whose kind is not among the ``known`` ones, for example misspelt or of another version."""
    return tuple(
        _described(point, kind, f"there is no kind {kind}. {did_you_mean(kind, tuple(known))}")
        for kind, points in sorted(_all_found(tuple(sys.path)).items())
        if kind not in known
        for point in points
    )


def _described(point: EntryPoint, kind: str, problem: str | None = None) -> Plugin:
    package, version = (point.dist.name, point.dist.version) if point.dist is not None else ("?", "?")
    return Plugin(kind, point.name, package, version, point.value, problem)

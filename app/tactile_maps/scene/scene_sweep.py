"""Sweeps of a scene: a sweep file states which settings of a scene file are varied and how.

    seconds = 3.0                                     # simulated time of each scene
    draws = 200                                       # number of random scenes; without it every combination
    seed = 1                                          # seed of the draws

    [vary]                                            # any setting of a scene, by its key
    seed = { from = 0, count = 50 }                   # integers 0 to 49
    control.controller = ["impedance", "hold_force"]  # each value of a list
    layer.stiffness = { from = 1e4, to = 1e6, steps = 5, log = true }
    stimuli.0.force = { from = 1.0, to = 8.0 }        # any value in between, only with draws
    stimuli.0.at = { from = [0.2, 0.0], to = [0.8, 1.0] }

A draw depends only on its number, its key and the seed: more draws or another key do not change the other values.
"""

from __future__ import annotations

import copy
import math
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias
from zlib import crc32

import numpy as np

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import SceneError
from tactile_maps.core.files import read_bounded_text
from tactile_maps.core.toml import KeyPath, TomlReader, toml_lines
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import scene_from_toml, scene_to_toml

MOST_SCENES = 1_000_000
Settings: TypeAlias = Mapping[str, Any]
"""Values by the dotted key of a scene file, as ``stimuli.0.force``."""
_TOP = ("seconds", "draws", "seed", "vary")
_RANGE = {"from", "to", "steps", "count", "log"}
_MAX_BYTES = 1_000_000
_HOW = "Write a list, { from, to, steps }, { from, count } or, with draws, { from, to }"


@dataclass(frozen=True)
class SceneSweep:
    """Settings of the varied scenes.

    Attributes:
        seconds: Simulated time of each scene [s].
        variants: The settings of each scene.
        file: The sweep file.
    """

    seconds: float
    variants: Sequence[Settings]
    file: str


def load_sweep(name: str | Path) -> SceneSweep:
    """Read a sweep file, or a shipped one by its name: ``pokes``.

    Raises:
        SceneError: The file cannot be read or is invalid; the message names the line and the key.
    """
    shipped = asset("sweeps", f"{name}.toml")
    path = shipped if os.path.isfile(shipped) else Path(name)
    reader = TomlReader(read_bounded_text(path, error=SceneError, most=_MAX_BYTES), file=str(path))
    for key in reader.raw:
        if key not in _TOP:
            remedy = f"Write {', '.join(_TOP[:3])} or [vary]"
            raise reader.error_at("unknown key", (key,), value=key, remedy=remedy)
    seconds = reader.value(reader.raw.get("seconds", 5.0), float, ("seconds",))
    if not 0 < seconds < 1e6:
        raise reader.error_at("the time is out of range", ("seconds",), value=seconds, remedy="Choose above 0 s")
    ways = dict(_ways(reader, reader.table("vary"), ("vary",)))
    draws = reader.value(reader.raw["draws"], int, ("draws",)) if "draws" in reader.raw else None
    seed = reader.value(reader.raw.get("seed", 0), int, ("seed",))
    _check_count(reader, ways, draws, seed)
    variants = _combined(ways) if draws is None else [_drawn(ways, seed, number) for number in range(draws)]
    return SceneSweep(seconds, variants, str(path))


def varied_scene(scene: Scene, settings: Settings, *, file: str) -> Scene:
    """Return the scene with these settings.

    Args:
        scene: The scene to vary.
        settings: Settings that replace those of the scene.
        file: The sweep file, for errors.

    Raises:
        SceneError: A setting is unknown or its value is invalid.
    """
    table = tomllib.loads(scene_to_toml(scene))
    for key, value in settings.items():
        _put(table, key.split("."), value, SceneError("unknown setting", file=file, place=f"vary.{key}"))
    try:
        return scene_from_toml(toml_lines(table), name=scene.name)
    except SceneError as error:
        # The line refers to the generated text, which the user does not see.
        place = ", ".join(part for part in (error.place or "").split(", ") if not part.startswith("line "))
        raise error.at(file=file, place=f"vary.{place}" if place else "vary") from error


@dataclass(frozen=True)
class _Way:
    """Variation of one setting: each of ``values``, or any number from ``low`` to ``high``."""

    values: Sequence[Any] = ()
    low: Any = None
    high: Any = None
    log: bool = False


def _ways(reader: TomlReader, table: Mapping[str, Any], path: KeyPath) -> Iterator[tuple[str, _Way]]:
    for key, value in table.items():
        place = (*path, key)
        if isinstance(value, Mapping) and not ("from" in value and set(value) <= _RANGE):
            yield from _ways(reader, value, place)
        else:
            yield ".".join(map(str, place[1:])), _way(reader, value, place)


def _way(reader: TomlReader, value: Any, path: KeyPath) -> _Way:
    if isinstance(value, list):
        if not value:
            raise reader.error_at("the list is empty", path, remedy=_HOW)
        return _Way(value)
    if not isinstance(value, Mapping):
        return _Way([value])
    first = value["from"]
    count = value.get("count")
    if set(value) == {"from", "count"} and type(first) is int and type(count) is int and 0 < count <= MOST_SCENES:
        return _Way(range(first, first + count))
    low = _numbers(first)
    high = _numbers(value.get("to"))
    log = value.get("log", False)
    steps = value.get("steps")
    right = low is not None and high is not None and len(low) == len(high) and "count" not in value
    right &= isinstance(first, list) == isinstance(value.get("to"), list)
    if not right or type(log) is not bool or not (steps is None or (type(steps) is int and 1 < steps <= MOST_SCENES)):
        raise reader.error_at("invalid range", path, value=value, remedy=_HOW)
    if log and low and high and min(low + high) <= 0:
        raise reader.error_at("a logarithmic range must be above 0", path, value=value)
    way = _Way(low=first, high=value["to"], log=log)
    return way if steps is None else _Way([_between(way, share) for share in np.linspace(0, 1, steps).tolist()])


def _numbers(value: Any) -> list[float] | None:
    """Return a finite number, or a list of them, as a list; None for any other value."""
    found = value if isinstance(value, list) else [value]
    right = bool(found) and all(type(one) in (int, float) and math.isfinite(one) for one in found)
    return [float(one) for one in found] if right else None


def _between(way: _Way, share: float | Sequence[float]) -> Any:
    """Return the value at a share of the range; for lists, each element at its own share."""
    if isinstance(way.low, list):
        shares = share if isinstance(share, Sequence) else [share] * len(way.low)
        each = zip(way.low, way.high, shares, strict=True)
        return [_between(_Way(low=low, high=high, log=way.log), one) for low, high, one in each]
    if share in (0.0, 1.0):
        return float(way.high if share else way.low)
    if way.log:
        return float(way.low * (way.high / way.low) ** share)
    return float(way.low + (way.high - way.low) * share)


def _check_count(reader: TomlReader, ways: Mapping[str, _Way], draws: int | None, seed: int) -> None:
    if seed < 0:
        raise reader.error_at("a seed cannot be negative", ("seed",), value=seed, remedy="Choose 0 or more")
    if draws is None:
        for key, way in ways.items():
            if not way.values:
                remedy = "Add steps = 5, or draws = 100 at the top"
                raise reader.error_at("the range has no number of steps", ("vary", *key.split(".")), remedy=remedy)
    count = math.prod(len(way.values) for way in ways.values()) if draws is None else draws
    if not 0 < count <= MOST_SCENES:
        place = ("vary",) if draws is None else ("draws",)
        raise reader.error_at(
            "the number of scenes is out of range", place, value=count, remedy=f"At most {MOST_SCENES:,}"
        )


def _combined(ways: Mapping[str, _Way]) -> list[Settings]:
    return [dict(zip(ways, values, strict=True)) for values in product(*(way.values for way in ways.values()))]


def _drawn(ways: Mapping[str, _Way], seed: int, number: int) -> Settings:
    return {key: _draw(way, np.random.default_rng((seed, number, crc32(key.encode())))) for key, way in ways.items()}


def _draw(way: _Way, random: np.random.Generator) -> Any:
    if way.values:
        return way.values[int(random.integers(len(way.values)))]
    return _between(way, random.random(len(way.low)).tolist() if isinstance(way.low, list) else random.random())


def _put(table: Any, keys: list[str], value: Any, error: SceneError) -> None:
    """Set the value at the keys; missing tables are created, missing list elements are not."""
    *parents, last = keys
    for key in parents:
        place = _place_in(table, key, error)
        table = table.setdefault(place, {}) if isinstance(table, dict) else table[place]
    table[_place_in(table, last, error)] = copy.deepcopy(value)


def _place_in(table: Any, key: str, error: SceneError) -> Any:
    if isinstance(table, dict):
        return key
    if not isinstance(table, list):
        raise error.at(value=key, remedy="It has no parts")
    if not key.isdecimal() or int(key) >= len(table):
        raise error.at(value=key, remedy=f"This scene has {len(table)} of them, counted from 0")
    return int(key)

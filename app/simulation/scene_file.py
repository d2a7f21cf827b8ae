"""Scenes as TOML files: read with every mistake named, written so that a recording holds its scene."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from app.errors import SceneError, TactileMapsError
from app.simulation.effects import Effects
from app.simulation.scene import Scene
from app.simulation.stimuli import Stroke
from app.skin.cover_spec import CoverSpec
from assets import asset

_CHOICES = {"gravity": ("off", "on", "compensated"), "contact": ("off", "self")}
_MAX_BYTES = 1_000_000


def scene_names() -> tuple[str, ...]:
    """Names of the scenes that ship with the app."""
    return tuple(sorted(path.stem for path in asset("scenes").glob("*.toml")))


def load_scene(name: str) -> Scene:
    """The scene of that name or file. In a file, the robot and its taxels may be named relative to its folder.

    Raises:
        SceneError: There is none, or it has a mistake; the message names the line or the key.
    """
    path = asset("scenes", f"{name}.toml") if name in scene_names() else Path(name)
    if not path.is_file():
        raise SceneError(
            "there is no such scene", value=name, remedy=f"Choose a file or one of: {', '.join(scene_names())}"
        )
    if path.stat().st_size > _MAX_BYTES:
        raise SceneError("the file is too large for a scene", file=path, value=f"{path.stat().st_size} bytes")
    try:
        text = path.read_text(encoding="utf8")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError("the scene cannot be read", file=path, value=error) from error
    scene = scene_from_toml(text, name=path.stem, file=str(path))
    robot, taxels = (_beside(path, value) for value in (scene.robot, scene.taxel_file))
    return replace(scene, robot=robot, taxel_file=taxels)


def scene_for(robot: str) -> Scene:
    """The scene for a robot's name or file: the shipped one of that name, or one with a cover and a stroke."""
    if robot in scene_names():
        return load_scene(robot)
    return Scene(name=Path(robot).stem or robot, robot=robot, title=Path(robot).name, strokes=(Stroke(),))


def scene_from_toml(text: str, *, name: str, file: str | None = None) -> Scene:
    """Read a scene.

    Raises:
        SceneError: Naming the key and the nearest valid one, or the value and what it must be.
    """
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError("the scene is not valid TOML", file=file or name, value=error) from error
    try:
        return _scene(raw, name)
    except SceneError as error:
        if error.file is not None and str(error.file) == file:
            raise
        raise SceneError(
            error.problem, file=file or name, place=error.place, value=error.value, remedy=error.remedy
        ) from error
    except TactileMapsError as error:
        raise SceneError(
            error.problem, file=file or name, place=error.place, value=error.value, remedy=error.remedy
        ) from error


def scene_to_toml(scene: Scene) -> str:
    """The same scene as text; reading it gives an equal scene."""
    flat = {key: value for key, value in asdict(scene).items() if not isinstance(value, dict) and key != "strokes"}
    parts = [
        _lines(flat),
        "[cover]",
        _lines(asdict(scene.cover)),
        "[effects]",
        _lines(asdict(scene.effects)),
        "[control]",
        _lines(dict(scene.control)),
    ]
    for stroke in scene.strokes:
        parts += ["[[strokes]]", _lines(asdict(stroke))]
    return "\n".join(parts) + "\n"


def _beside(scene: Path, value: str) -> str:
    """A file's name that is meant from the scene's folder, as a path; anything else unchanged."""
    return str(scene.parent / value) if value and (scene.parent / value).is_file() else value


def _scene(raw: dict[str, Any], name: str) -> Scene:
    values = _checked(Scene, {"name": name, **raw}, "scene", skip=("cover", "effects", "control", "strokes"))
    control = _table(raw, "control")
    bad = [key for key, value in control.items() if isinstance(value, bool) or not isinstance(value, str | int | float)]
    if bad:
        raise SceneError(
            "a controller setting must be a number or a word", place=f"control.{bad[0]}", value=control[bad[0]]
        )
    strokes = raw.get("strokes", [])
    if not isinstance(strokes, list) or not all(isinstance(stroke, dict) for stroke in strokes):
        raise SceneError("strokes must be tables", place="strokes", remedy="Write [[strokes]] above each")
    return Scene(
        **values,
        cover=CoverSpec(**_checked(CoverSpec, _table(raw, "cover"), "cover")),
        effects=Effects(**_checked(Effects, _table(raw, "effects"), "effects")),
        control={key: value if isinstance(value, str) else float(value) for key, value in control.items()},
        strokes=tuple(Stroke(**_checked(Stroke, stroke, "strokes")) for stroke in strokes),
    )


def _table(raw: Mapping[str, Any], key: str) -> dict[str, Any]:
    value = raw.get(key, {})
    if not isinstance(value, dict):
        raise SceneError("this must be a table", place=key, value=value, remedy=f"Write [{key}] above its lines")
    return value


def _checked(kind: type, raw: Mapping[str, Any], place: str, *, skip: tuple[str, ...] = ()) -> dict[str, Any]:
    """Keyword arguments for a dataclass: known keys, each of its field's kind."""
    known = {f.name: f for f in fields(kind)}
    result: dict[str, Any] = {}
    for key, value in raw.items():
        if key not in known:
            close = get_close_matches(key, known, n=1)
            raise SceneError(
                "there is no such key",
                place=place,
                value=key,
                remedy=f"Did you mean {close[0]}?" if close else f"Known keys: {', '.join(known)}",
            )
        if key not in skip:
            field = known[key]
            result[key] = _value(value, "" if field.default is MISSING else field.default, f"{place}.{key}", key)
    needed = [f.name for f in known.values() if f.default is MISSING and f.default_factory is MISSING]
    missing = [name for name in needed if name not in raw]
    if missing:
        raise SceneError("a key is missing", place=place, value=missing[0])
    return result


def _value(value: Any, default: Any, place: str, key: str) -> Any:
    """The value as the kind that the default is."""
    if key in _CHOICES and value not in _CHOICES[key]:
        raise SceneError(
            "there is no such choice", place=place, value=value, remedy=f"Choose one of: {', '.join(_CHOICES[key])}"
        )
    wanted = type(default)
    if wanted is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if wanted is tuple and isinstance(value, list):
        numbers = bool(default) and isinstance(default[0], float)
        items = tuple(_value(item, 0.0 if numbers else "", place, "") for item in value)
        if numbers and len(items) != len(default):
            raise SceneError(f"this must be {len(default)} numbers", place=place, value=value)
        return items
    if type(value) is not wanted:
        raise SceneError(f"this must be a {wanted.__name__}", place=place, value=value)
    return value


def _lines(values: Mapping[str, Any]) -> str:
    return "\n".join(
        f"{key if re.fullmatch('[A-Za-z0-9_-]+', key) else _toml(key)} = {_toml(value)}"
        for key, value in values.items()
    )


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # JSON's escapes are TOML's too, but for DEL, which TOML wants escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return repr(value)

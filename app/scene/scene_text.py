"""A scene as TOML text and back; what is written reads as an equal scene, so that a recording holds its own."""

from __future__ import annotations

import math
from dataclasses import asdict

from app.scene.motion import Waypoint
from app.scene.objects import ObjectSpec
from app.scene.scene import Scene, Setting
from app.skin.cover_spec import CoverSpec
from app.stimuli.stimulus_file import read_stimulus, stimulus_to_table
from app.toml.lines import toml_lines
from app.toml.reader import TomlReader
from app.toml.units import as_float
from app.touch.layer import Layer

_POINTS = ("path",)
"""Settings of the controller that are lists of points."""
_PLAIN = ("name", "title", "robot", "task", "outputs", "taxel_file", "tick", "seed")
_TABLES = ("cover", "layer", "objects", "effects", "control", "contacts", "behaviours", "motion", "stimuli")


def scene_from_toml(text: str, *, name: str, file: str | None = None) -> Scene:
    """Read a scene.

    Args:
        text: TOML.
        name: Of the scene, where the text does not say.
        file: Where the text came from, for messages.

    Raises:
        SceneError: Naming the line and the key, the value, what is allowed there and the nearest spelling.
    """
    reader = TomlReader(text, file=file or name, top=_PLAIN)
    known = {key: value for key, value in reader.raw.items() if key not in _TABLES}
    values = reader.fields(Scene, {"name": name, **known}, ())
    values |= {
        "cover": reader.build(CoverSpec, reader.table("cover"), ("cover",)),
        "layer": reader.build(Layer, reader.table("layer"), ("layer",)),
        "objects": tuple(reader.build(ObjectSpec, *place) for place in reader.tables("objects")),
        "wishes": reader.table("effects"),
        "control": _control(reader),
        "reading": _contacts(reader),
        "behaviours": tuple(table for table, _ in reader.tables("behaviours")),
        "motion": tuple(reader.build(Waypoint, *place) for place in reader.tables("motion")),
        "stimuli": tuple(read_stimulus(reader, *place) for place in reader.tables("stimuli")),
    }
    with reader.locating(reader.raw, ()):
        return Scene(**values)


def scene_to_toml(scene: Scene) -> str:
    """The same scene as text; reading it gives an equal scene."""
    parts = [toml_lines({key: getattr(scene, key) for key in _PLAIN})]
    tables = {"cover": asdict(scene.cover), "layer": asdict(scene.layer), "effects": scene.wishes}
    for key, table in (tables | {"control": scene.control, "contacts": scene.reading}).items():
        parts += [f"[{key}]", toml_lines(table)]
    lists = {
        "objects": map(asdict, scene.objects),
        "behaviours": scene.behaviours,
        "motion": map(asdict, scene.motion),
        "stimuli": map(stimulus_to_table, scene.stimuli),
    }
    for key, items in lists.items():
        for item in items:
            parts += [f"[[{key}]]", toml_lines(item)]
    return "\n".join(parts) + "\n"


def _control(reader: TomlReader) -> dict[str, Setting]:
    """Words, numbers, infinity among them, and points; the controller knows which names there are."""
    result: dict[str, Setting] = {}
    for key, value in reader.table("control").items():
        if key in _POINTS:
            result[key] = reader.value(value, tuple[tuple[float, float], ...], ("control", key))
            continue
        number = as_float(value) if type(value) in (int, float) else math.nan
        if math.isnan(number) and not isinstance(value, str):
            problem = "a controller setting must be a number or a word"
            raise reader.mistake(problem, ("control", key), value=value)
        result[key] = value if isinstance(value, str) else number
    return result


def _contacts(reader: TomlReader) -> dict[str, str | float]:
    """Words and numbers; who reads contacts knows which names there are."""
    table = reader.table("contacts")
    for key, value in table.items():
        if type(value) not in (int, float, str):
            raise reader.mistake("this must be a number or a word", ("contacts", key), value=value)
    return table

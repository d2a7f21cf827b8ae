"""A scene as TOML text and back; what is written reads as an equal scene, so that a recording holds its own."""

from __future__ import annotations

import math
from dataclasses import asdict

from app.scene.motion import Waypoint
from app.scene.objects import ObjectSpec
from app.scene.scene import Scene
from app.skin.cover_spec import CoverSpec
from app.stimuli.stimulus_file import read_stimulus, stimulus_to_table
from app.toml.lines import toml_lines
from app.toml.reader import TomlReader
from app.toml.units import as_float
from app.touch.layer import Layer

_PLAIN = ("name", "title", "robot", "task", "outputs", "taxel_file", "tick", "seed")
_TABLES = ("cover", "layer", "objects", "effects", "control", "motion", "stimuli")


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
        "motion": tuple(reader.build(Waypoint, *place) for place in reader.tables("motion")),
        "stimuli": tuple(read_stimulus(reader, *place) for place in reader.tables("stimuli")),
    }
    with reader.locating(reader.raw, ()):
        return Scene(**values)


def scene_to_toml(scene: Scene) -> str:
    """The same scene as text; reading it gives an equal scene."""
    parts = [toml_lines({key: getattr(scene, key) for key in _PLAIN})]
    tables = {"cover": asdict(scene.cover), "layer": asdict(scene.layer), "effects": scene.wishes}
    for key, table in (tables | {"control": scene.control}).items():
        parts += [f"[{key}]", toml_lines(table)]
    lists = {"objects": map(asdict, scene.objects), "motion": map(asdict, scene.motion)}
    for key, items in (lists | {"stimuli": map(stimulus_to_table, scene.stimuli)}).items():
        for item in items:
            parts += [f"[[{key}]]", toml_lines(item)]
    return "\n".join(parts) + "\n"


def _control(reader: TomlReader) -> dict[str, str | float]:
    """Words and numbers, infinity among them; the controller knows which names there are."""
    result: dict[str, str | float] = {}
    for key, value in reader.table("control").items():
        number = as_float(value) if type(value) in (int, float) else math.nan
        if math.isnan(number) and not isinstance(value, str):
            problem = "a controller setting must be a number or a word"
            raise reader.mistake(problem, ("control", key), value=value)
        result[key] = value if isinstance(value, str) else number
    return result

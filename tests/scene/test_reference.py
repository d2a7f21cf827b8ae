"""The reference in ``assets/scenes/README.md`` lists exactly what the readers of a scene accept."""

from __future__ import annotations

import re
import tomllib
from dataclasses import MISSING, fields
from typing import get_args

import pytest

from tactile_maps.contacts.detection.image_centre import BACK_PROJECTIONS
from tactile_maps.contacts.events import EVENT_KINDS
from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.behaviours import Behaviour
from tactile_maps.control.controller_registry import settings_from
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.core.assets import asset
from tactile_maps.core.toml import toml_lines
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene import scene_file
from tactile_maps.scene.effects import EFFECTS, SENSOR_KEYS
from tactile_maps.scene.motion import Unit, Waypoint
from tactile_maps.scene.objects import OBJECT_KINDS, ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import scene_from_toml, scene_names
from tactile_maps.scene.tasks import OUTPUTS, TASKS, TOUCH_OUTPUTS
from tactile_maps.session.prepare import load_robot_and_skin
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_maps.stimuli.stimulus_file import STIMULUS_KINDS
from tactile_maps.tactile.babbling import KINDS
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

REFERENCE = asset("scenes", "README.md").read_text(encoding="utf8")


def section(title: str) -> str:
    """The text below a heading, up to the next."""
    (found,) = re.findall(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", REFERENCE, re.MULTILINE | re.DOTALL)
    return found


def words(text: str) -> list[str]:
    """Return the words between backticks, without the defaults at the end."""
    return re.findall(r"`([^`]+)`", re.sub(r"\(default [^()]*\)", "", text))


def tables(text: str) -> list[list[list[str]]]:
    """Each table as rows of cells, without its two first lines."""
    found = [table.splitlines()[2:] for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)]
    return [[[cell.strip() for cell in row.strip("|\n").split("|")] for row in table] for table in found]


def keys(table: list[list[str]]) -> list[str]:
    """All names in the first column."""
    return [word for row in table for word in words(row[0])]


def names(kind: type) -> list[str]:
    return sorted(field.name for field in fields(kind))


KINDS_BY_TABLE = [
    ("`[cover]`", CoverSpec),
    ("`[layer]`", ElasticLayer),
    ("`[[objects]]`", ObjectSpec),
    ("`[[motion]]`", Waypoint),
    ("`[[grids]]`", GridSpec),
    ("`[control]`", ControlSettings),
    ("`[contacts]`", ReadingSettings),
    ("`[[behaviours]]`", Behaviour),
]


@pytest.mark.parametrize(("title", "kind"), KINDS_BY_TABLE)
def test_each_table_lists_its_keys(title, kind):
    (table,) = tables(section(title))
    assert sorted(keys(table)) == names(kind)


def stated_defaults(row: list[str]) -> dict[str, object]:
    """The defaults at the end of a row, by key; nothing where they are described in words."""
    (text,) = re.findall(r"\(default ([^()]*)\)", row[1]) or [""]
    values = re.findall(r"`([^`]+)`|(?<![\w.`])(-?\d[\d.e-]*)", text)
    listed = words(row[0])
    if len(values) != len(listed):
        return {}
    return {key: _value(word or number) for key, (word, number) in zip(listed, values, strict=True)}


def _value(text: str) -> object:
    """A value as TOML has it, or the word itself."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


@pytest.mark.parametrize(("title", "kind"), KINDS_BY_TABLE)
def test_stated_defaults_match_the_code(title, kind):
    (table,) = tables(section(title))
    stated = {key: value for row in table for key, value in stated_defaults(row).items()}
    made = {field.name: field.default for field in fields(kind) if field.default is not MISSING}
    made = {key: list(value) if isinstance(value, tuple) else value for key, value in made.items()}
    assert stated == {key: value for key, value in made.items() if key in stated}
    assert len(stated) >= len(made) // 3


def test_top_level_lists_its_keys_and_every_table():
    (table,) = tables(REFERENCE.partition("\n## ")[0])
    listed = keys(table)
    assert sorted(key for key in listed if "[" not in key) == sorted(scene_file._PLAIN)
    assert sorted(key.strip("[]") for key in listed if "[" in key) == sorted(scene_file._TABLES)


def test_stimuli_list_each_kind_with_its_keys():
    kinds, shared = tables(section("`[[stimuli]]`"))
    assert sorted(keys(kinds)) == sorted(STIMULUS_KINDS)
    assert sorted(keys(shared)) == names(Stimulus)
    for (kind,), listed in ((words(row[0]), words(row[2])) for row in kinds):
        own = set(names(STIMULUS_KINDS[kind])) - set(names(Stimulus))
        assert {key for key in listed if "[" not in key} == own, kind


def test_effects_are_listed_with_their_choices_and_numbers():
    physics, sensor = tables(section("Effects"))
    assert sorted(keys(physics)) == sorted(set(EFFECTS) - set(SENSOR_KEYS))
    assert sorted(keys(sensor)) == sorted(SENSOR_KEYS)
    for row in physics:
        for key in words(row[0]):
            if EFFECTS[key].choices:
                assert tuple(row[1].split(", ")) == EFFECTS[key].choices, key
    for row in sensor:
        (key,) = words(row[0])
        assert words(row[1]) == list(EFFECTS[key].options), key


CHOICES_BY_KEY = {
    "`[[objects]]`": {"kind": OBJECT_KINDS},
    "`[[motion]]`": {"unit": get_args(Unit)},
    "`[control]`": CHOICES,
    "`[contacts]`": {
        "estimator": ESTIMATORS,
        "interpolation": tuple(INTERPOLATIONS),
        "back_projection": BACK_PROJECTIONS,
    },
    "`[[behaviours]]`": {"on": EVENT_KINDS},
}


@pytest.mark.parametrize("title", CHOICES_BY_KEY)
def test_choices_are_listed(title):
    (table,) = tables(section(title))
    listed = {word: words(row[1]) for row in table for word in words(row[0])}
    for key, choices in CHOICES_BY_KEY[title].items():
        assert listed[key] == list(choices), key


def test_ways_to_babble_tasks_outputs_and_scenes_are_listed():
    assert words(section("`[[stimuli]]`").splitlines()[-2])[2:] == list(KINDS)
    tasks, outputs = tables(section("Tasks and outputs"))
    assert keys(tasks) == list(TASKS)
    assert keys(outputs) == list(OUTPUTS)
    (shipped,) = tables(section("Shipped scenes"))
    assert sorted(keys(shipped)) == sorted(scene_names())


@pytest.mark.parametrize("field", fields(ControlSettings), ids=lambda field: field.name)
def test_each_setting_of_the_controller_can_be_written(field):
    text = f'robot = "arm"\n[control]\n{toml_lines({field.name: field.default})}\n'
    assert settings_from(scene_from_toml(text, name="x").control) == ControlSettings()


def test_table_of_contact_models_lists_depth_and_outputs():
    text = section("Pressure")
    (table,) = tables(text)
    assert keys(table) == [choice for choice in EFFECTS["skin"].choices if choice != "off"]
    assert [words(row[0])[0] for row in table if "`depth` below" in row[1]] == ["half-space"]
    assert all("surface" in row[1] for row in table)
    outputs = [output for output in TOUCH_OUTPUTS if output not in ("pressure", "readings")]
    headings = next(line for line in text.splitlines() if line.startswith("| `skin`"))
    assert words(headings) == ["skin", *outputs]
    assert all(len(row) == 2 + len(outputs) and all(row) for row in table)


@pytest.mark.parametrize("height", [-0.3, 0.0, 0.2])
def test_skin_without_robot_is_at_the_stated_height(height, tmp_path):
    taxels = tmp_path / "pad.csv"
    steps = (0.02, 0.03, 0.04, 0.05)
    rows = [f"{x},{y},{height},0,0,1" for x in steps for y in steps]
    taxels.write_text("x,y,z,nx,ny,nz\n" + "\n".join(rows))
    robot, skin = load_robot_and_skin(Scene(name="pad", robot="none", taxel_files=(str(taxels),)))
    kinematics = Configuration(robot)
    points = kinematics.pose(skin.patches[0].link).points(skin.patches[0].surface.vertices)
    (stated,) = re.findall(r"their lowest point is ([\d.]+) m above\s+the ground", REFERENCE)
    assert points[:, 2].min() == pytest.approx(float(stated), abs=1e-9)
    assert points[:, :2] == pytest.approx(skin.patches[0].surface.vertices[:, :2], abs=1e-12)

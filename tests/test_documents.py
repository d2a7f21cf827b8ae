"""What the README promises is what the checkout does."""

from __future__ import annotations

import tomllib
from pathlib import Path

from app.scene.scene_file import scene_from_toml

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf8")


def test_ci_runs_the_readmes_test_command():
    assert "sh tests/run.sh" in README
    script = [line for line in (ROOT / ".ci/run").read_text().splitlines() if line and not line.startswith("#")]
    assert script[-1] == "sh tests/run.sh"


def test_every_dependency_has_its_line():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = project["dependencies"] + [d for extra in project["optional-dependencies"].values() for d in extra]
    names = {d.split(">")[0].split("<")[0].split(";")[0].strip() for d in wanted}
    assert len(names) > 15
    assert not {name for name in names if f"`{name}`" not in README}


def test_pictures_exist():
    pictures = [part.split(")")[0] for part in README.split("](")[1:] if part.split(")")[0].endswith(".png")]
    assert pictures
    assert not [picture for picture in pictures if not (ROOT / picture).is_file()]


def test_the_readmes_scene_can_be_read_and_lacks_nothing():
    scene = scene_from_toml(README.split("```toml\n")[1].split("```")[0], name="readme", file="README.md")
    assert scene.effects.friction
    assert scene.effects.sensor.noise is not None
    assert not scene.decision.warnings

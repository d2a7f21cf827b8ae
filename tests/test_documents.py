"""README and guide match the program: links, pictures, examples, versions, sizes."""

from __future__ import annotations

import csv
import json
import pkgutil
import re
import shlex
import tomllib
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import yaml

from tactile_maps.cli.commands.guide import page_names
from tactile_maps.cli.parser import build_parser
from tactile_maps.robots.library import list_robots
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.scene_file import load_scene, scene_from_toml, scene_names
from tactile_maps.studies.catalogue import STUDY_NAMES
from tactile_maps.studies.loop_laws.loop_laws import LOOP_GAINS
from tactile_maps.studies.loop_laws.predictions import IDEAL_JOINTS
from tactile_maps.studies.running.sequential import Settled
from tactile_maps.studies.sweeps.needs import Verdict
from tests import contact_page, robots_page
from tests.findings_page import FIGURES, JUDGED, PAGE, TABLES, as_shipped, figures, mark, page, race, table

ROOT = Path(__file__).resolve().parents[1]
GUIDE = ROOT / "assets" / "guide"
README = (ROOT / "README.md").read_text(encoding="utf8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))["project"]
ROOT_DOCUMENTS = tuple(ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CONTRIBUTING", "CODE_OF_CONDUCT"))
DOCUMENTS = (*ROOT_DOCUMENTS, ROOT / "assets/scenes/README.md", *sorted(GUIDE.glob("*.md")))
MOST_PICTURE_BYTES = 250_000


def blocks(text: str, language: str) -> list[str]:
    """Return the fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def links(path: Path) -> list[str]:
    """Return the targets of links and pictures in a document, except web addresses."""
    prose = re.sub(r"^```.*?^```|`[^`\n]*`", "", path.read_text(encoding="utf8"), flags=re.MULTILINE | re.DOTALL)
    return [link for link in re.findall(r"\]\(([^)\s]+)\)", prose) if "://" not in link]


def anchors(path: Path) -> set[str]:
    """Return the anchors of a document's headings."""
    headings = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_readme_has_at_most_9000_characters():
    assert len(README) <= 9_000


def test_ci_runs_test_command_of_readme():
    assert "sh tests/run.sh" in README
    script = [line for line in (ROOT / ".ci/run").read_text().splitlines() if line and not line.startswith("#")]
    assert script[-1] == "sh tests/run.sh"


def test_workflow_runs_the_same_script_on_all_systems_and_stated_versions_of_python():
    job = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text())["jobs"]["tests"]
    assert job["steps"][-1]["run"] == "sh tests/run.sh ${{ matrix.options }}"
    matrix = job["strategy"]["matrix"]
    assert [system.split("-")[0] for system in matrix["system"]] == ["ubuntu", "macos", "windows"]
    stated = re.findall(r"Python :: (3\.\d+)", " ".join(PROJECT["classifiers"]))
    assert matrix["python"] == stated
    assert PROJECT["requires-python"] == f">={stated[0]}"


def test_changelog_entries_are_short_and_in_standard_sections():
    """Each section of a version appears once, in this order, and each entry has at most 120 characters."""
    versions = re.split(r"^## ", (ROOT / "CHANGELOG.md").read_text(encoding="utf8"), flags=re.MULTILINE)[1:]
    sections = ["Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"]
    for version in versions:
        found = re.findall(r"^### (\w+)$", version, re.MULTILINE)
        assert found == [name for name in sections if name in found]
        assert found
        assert not [line for line in version.splitlines() if line.startswith("- ") and len(line) > 120]


def test_readme_lists_every_dependency():
    required = PROJECT["dependencies"] + [d for extra in PROJECT["optional-dependencies"].values() for d in extra]
    names = {re.match(r"[\w.-]+", dependency)[0] for dependency in required}
    assert len(names) > 15
    assert not {name for name in names if f"`{name}`" not in README}


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_link_targets_exist(path):
    for link in links(path):
        target, _, anchor = link.partition("#")
        found = (path.parent / target).resolve() if target else path
        assert found.is_file(), f"{path.name}: {link}"
        assert not anchor or anchor in anchors(found), f"{path.name}: {link}"
        assert found.is_relative_to(ROOT / "assets") or path in ROOT_DOCUMENTS, f"{link} is not in the wheel"


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_modules_and_files_named_in_documents_exist(path):
    prose = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf8"), flags=re.MULTILINE | re.DOTALL)
    for name in re.findall(r"`(?:python -m )?((?:tactile_maps|tactile_widgets|tests)(?:\.\w+)+)", prose):
        assert pkgutil.resolve_name(name) is not None, name
    for file in re.findall(r"`((?:app|widgets|tests|assets|\.github)/[\w/.-]+)`", prose):
        assert (ROOT / file).exists() or "icub-main" in prose, file


def test_index_links_all_pages_and_pictures_are_used_and_small():
    reached = {(GUIDE / link).resolve() for link in links(GUIDE / "index.md")}
    assert {GUIDE / f"{name}.md" for name in page_names()} - {GUIDE / "index.md"} <= reached
    shown = {(path.parent / link).resolve() for path in DOCUMENTS for link in links(path)}
    pictures = set(GUIDE.glob("*.png"))
    assert len(pictures) >= 5
    assert pictures <= shown
    assert not {picture.name for picture in pictures if picture.stat().st_size > MOST_PICTURE_BYTES}


def test_scene_in_guide_loads_without_warnings():
    (text,) = blocks((GUIDE / "touch.md").read_text(encoding="utf8"), "toml")
    scene = scene_from_toml(text, name="guide", file="touch.md")
    assert scene.effects.friction
    assert scene.effects.sensor.noise is not None
    assert not scene.decision.warnings


def test_guide_table_of_effects_matches_shipped_rows():
    rows = list(csv.DictReader((ROOT / "assets" / "findings" / "needs.csv").read_text(encoding="utf8").splitlines()))
    text = (GUIDE / "accuracy.md").read_text(encoding="utf8")
    shown = [verdict for verdict in Verdict if verdict is not Verdict.NO_OUTPUT]
    for effect in EFFECTS:
        found = [row["verdict"] for row in rows if row["effect"] == effect]
        cells = [str(found.count(verdict.value) or "") for verdict in shown]
        assert f"| {EFFECTS[effect].title} | {' | '.join(cells)} |" in text
    assert f"{len({row['scene'] for row in rows})} in all" in text


def test_guide_measurements_match_shipped_rows():
    text = " ".join((GUIDE / "accuracy.md").read_text(encoding="utf8").split())
    rows = json.loads((ROOT / "assets" / "stability.json").read_text(encoding="utf8"))["rows"]
    steps = sorted({row["timestep_ms"] for row in rows})
    stable = {
        name: [
            max(
                row["stiffness"]
                for row in rows
                if (row["integrator"], row["timestep_ms"], row["verdict"]) == (name, step, "steady")
            )
            for step in steps
        ]
        for name in ("implicitfast", "discrete")
    }
    took = {(row["integrator"], row["timestep_ms"], row["stiffness"]): row["ms"] for row in rows}
    ratios = [
        took["discrete", *case] / ms for (name, *case), ms in took.items() if name == "implicitfast" and ms is not None
    ]
    (most,) = set(stable["discrete"])
    assert (
        f"at {'; '.join(f'{step:g}' for step in steps)} ms `implicitfast` is stable up to "
        f"{'; '.join(f'{1e-3 * stiffness:g}' for stiffness in stable['implicitfast'])} kN/m; "
        f"`discrete` up to {1e-6 * most:g} MN/m at all of them, for {np.median(ratios):.1f} times the time"
    ) in text
    laws = [row for row in table("loop-laws") if row["plant"] == IDEAL_JOINTS]
    off = {
        law: [row["measured"] / row["predicted"] for row in laws if row["law"] == law] for law in ("settling", "onset")
    }
    ripple = [
        np.median([row["measured"] / row["predicted"] for row in laws if (row["law"], row["x"]) == ("ripple", gain)])
        for gain in LOOP_GAINS
    ]
    assert set(off["settling"]) == {1.0}
    assert "steps settle to the sample" in text
    assert f"oscillate at a stiffness {100 * (max(off['onset']) - 1):.1f} % above theory's" in text
    assert min(off["onset"]) > 1
    assert f"ripple is within {100 * max(abs(value - 1) for value in ripple):.1f} %" in text


def test_shipped_tables_take_less_than_2_mb():
    shipped = [path for path in (ROOT / "assets" / "findings").rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in shipped) < 2_000_000


def test_contact_page_matches_shipped_rows():
    assert contact_page.PAGE.read_text(encoding="utf8") == contact_page.page(), (
        "to update it: python -m tests.contact_page"
    )


def test_robots_page_matches_shipped_rows():
    assert robots_page.PAGE.read_text(encoding="utf8") == robots_page.page(), (
        "to update it: python -m tests.robots_page"
    )


@pytest.mark.long
def test_findings_page_matches_shipped_rows():
    assert PAGE.read_text(encoding="utf8") == page(), "to update it: python -m tests.findings_page"


@pytest.mark.parametrize("study", JUDGED)
def test_shipped_tables_keep_columns_and_five_digits(study):
    text = (TABLES / f"{study}.csv").read_text(encoding="utf8")
    kept = text.partition("\n")[0].split(",")
    longer = text.replace("\n", ",3.14159265\n").replace(",3.14159265", ",another", 1)
    assert as_shipped(longer, kept) == text
    assert as_shipped("a,b,c\n1.23456789,x,7\n", ("a", "c")) == "a,c\n1.2346,7\n"


def test_decisions_with_fewer_runs_agree_with_those_of_all_seeds():
    races = [race(study) for study in ("representation", "force-feedback")]
    verdicts = [verdict for one in races for verdict in one.verdicts.values()]
    assert sum(one.run for one in races) < 0.65 * sum(one.cases for one in races)
    assert {Settled.DIFFERS, Settled.EQUIVALENT} <= {full for full, _ in verdicts}
    assert not [verdict for verdict in verdicts if set(verdict) == {Settled.DIFFERS, Settled.EQUIVALENT}], (
        "opposite decision"
    )
    assert sum(full is raced for full, raced in verdicts) > 0.95 * len(verdicts)


def test_figures_of_findings_match_shipped_rows():
    drawn = {path.name: path.read_text(encoding="utf8") for path in FIGURES.glob("*.svg")}
    expected = figures()
    assert sorted(drawn) == sorted(expected), "to update them: python -m tests.findings_page"
    assert [name for name, figure in expected.items() if mark(figure) not in drawn[name]] == []
    text = PAGE.read_text(encoding="utf8")
    assert [name for name in expected if f"(../findings/figures/{name})" not in text] == []


def test_guide_lists_every_command_and_study():
    text = (GUIDE / "commands.md").read_text(encoding="utf8")
    commands = next(action.choices for action in build_parser()._actions if action.dest == "command")
    assert not [name for name in commands if f"`tactile-maps {name}" not in text.replace("[gui]", "gui")]
    assert not [name for name in STUDY_NAMES if f"`{name}`" not in text]


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_commands_in_documents_parse_and_their_scenes_exist(path):
    """Checks lines that contain only a command; names in capitals are placeholders."""
    text = path.read_text(encoding="utf8")
    for line in re.findall(r"^(?: {4})?(?:\.venv/bin/)?tactile-maps (.+)$", text, re.MULTILINE):
        arguments = build_parser().parse_args(shlex.split(line, comments=True))
        scene = getattr(arguments, "scene", None)
        assert scene is None or scene.isupper() or "." in scene or scene in scene_names(), line


@pytest.mark.sampled(2)
@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_menus_named_in_documents_exist(path):
    """Checks menu paths such as *File > Open robot*; entries of lists are titles of scenes or robots."""
    from tactile_widgets.actions.registry import ActionSpec, Line, MenuList
    from tactile_widgets.actions.table import menu_bar

    text = path.read_text(encoding="utf8")
    named = [" ".join(found.split()) for found in re.findall(r"(?<!\*)\*([A-Z][^*]*? >\s[^*]+)\*", text)]
    assert len(named) == len(re.findall(r"\b[A-Z]\w+ >\s+[A-Z]", text)), "menus are in italics"
    shown = {load_scene(name).title for name in scene_names()} | {entry.title for entry in list_robots()}
    for name in named:
        items = menu_bar()
        for part in (parts := name.split(" > ")):
            if items is None:
                assert part in shown, name
                continue
            texts = {
                (item.text if isinstance(item, ActionSpec) else item.title).split("…")[0].split(" (")[0]: item
                for item in items
                if not isinstance(item, Line)
            }
            assert part in texts, f"{path.name}: {name}"
            items = None if isinstance(texts[part], MenuList) else getattr(texts[part], "items", ())
        assert len(parts) > 1


def test_versions_in_project_citation_and_changelog_agree():
    version = PROJECT["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf8")
    assert re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf8"), re.MULTILINE)[1] == version


def run(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """Run an example in an empty folder, like a notebook, and return its names."""
    import matplotlib as mpl
    from matplotlib import pyplot

    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(mpl.rcParams, "backend", "agg")
    names: dict[str, object] = {}
    try:
        exec(compile(text, "example", "exec"), names)
    finally:
        pyplot.close("all")
    return names


def readme_example() -> str:
    (text,) = blocks(README, "python")
    return text


def test_readme_example_has_at_most_fifteen_lines():
    assert len([line for line in readme_example().splitlines() if line.strip()]) <= 15


def check_readme_example(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = run(text, tmp_path, monkeypatch)
    skin, frame, place, at = (names[name] for name in ("skin", "frame", "place", "at"))
    assert names["pressures"] @ skin.areas == pytest.approx(3.0)
    assert names["contacts"][0].force == pytest.approx(3.0)
    assert np.linalg.norm(place.link_position - skin.position(at)) < 0.01
    assert frame.regions[0].force == pytest.approx(2.0, abs=0.1), "the arm retreats to its goal"
    assert np.abs(frame.posture - names["robot"].home).max() > 1e-3


@pytest.mark.long
@pytest.mark.robots
def test_readme_example_runs_on_icub(tmp_path, monkeypatch):
    icub = next(entry for entry in list_robots() if entry.name == "icub")
    if not icub.available:
        pytest.skip(f"the example's robot is not installed: {icub.remedy}")
    check_readme_example(readme_example(), tmp_path, monkeypatch)


@pytest.mark.long
def test_readme_example_runs_on_shipped_robot(tmp_path, monkeypatch):
    text = readme_example().replace('"icub"', '"arm"').replace('"l_forearm"', '"forearm"')
    assert text != readme_example()
    check_readme_example(text, tmp_path, monkeypatch)


@pytest.mark.long
def test_library_example_of_guide_runs(tmp_path, monkeypatch):
    (text,) = blocks((GUIDE / "library.md").read_text(encoding="utf8"), "python")
    names = run(text, tmp_path, monkeypatch)
    assert names["quality"].flips == 0
    assert (tmp_path / "press.mcap").stat().st_size > 0


def test_functions_that_the_library_page_names_exist():
    text = (ROOT / "assets" / "guide" / "library.md").read_text(encoding="utf8")
    named = re.findall(r"`([a-z_]+)(?:\([a-z]*\))?` of\s+`(tactile_maps[a-z_.]+)`", text)
    assert {"contact_note_text", "limit_texts"} <= {name for name, _ in named}
    for name, module in named:
        assert callable(getattr(import_module(module), name))

"""Every output of every command is checked before the command starts, by the same rules."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tactile_maps.cli.main import run_command
from tactile_maps.cli.parser import build_parser
from tests.support.special_files import is_special, make_special_file, special_kinds

WORDS = {
    "calibrate": ["in.csv"],
    "check": ["in.csv"],
    "compare": ["slide", "--controllers", "qp"],
    "export": ["in.mcap", "--to", "csv"],
    "film": ["in.mcap"],
    "inspect": ["arm"],
    "listen": ["in.csv", "--weight", "1"],
    "map": ["in.stl"],
    "place": ["in.csv"],
    "recover": ["in.mcap"],
    "replay": ["in.mcap"],
    "run": ["arm"],
    "screenshot": [],
    "study": ["map-cost"],
    "trim": ["in.mcap"],
    "weigh": ["arm"],
}
"""Words that each command with an output requires besides it; ``in`` does not exist, so none gets further."""
INPUTS = {
    "": {"scene", "robot", "skin", "package_root"},
    "map": {"uv", "compare", "input"},
    "run": {"stimuli", "sweep"},
    "check": {"ids", "mapping", "token_file"},
    "place": {"touches", "readings"},
    "listen": {"ids", "calibration", "mapping", "token_file"},
}
"""Options that name a file to read, by command; the first are those of many commands."""


def commands() -> dict[str, argparse.ArgumentParser]:
    (action,) = [one for one in build_parser()._actions if isinstance(one, argparse._SubParsersAction)]
    return dict(action.choices)


def outputs() -> Iterator[tuple[str, str, str]]:
    """Command, option and the name of its value, for every output."""
    for command, parser in commands().items():
        for name, *_ in parser.get_default("outputs") or ():
            (action,) = [one for one in parser._actions if one.dest == name]
            yield command, action.option_strings[-1], name


OUTPUTS = sorted((command, option) for command, option, _ in outputs())


def ending_of(command: str, option: str) -> str:
    """Extension that the help of an output states; empty if it states none."""
    (action,) = [one for one in commands()[command]._actions if option in one.option_strings]
    return "".join(re.findall(r"\.\w+", str(action.metavar)))


def test_every_option_that_names_a_file_is_an_output_or_a_known_input():
    known = {(command, name) for command, _, name in outputs()}
    for command, parser in commands().items():
        for action in parser._actions:
            named = action.option_strings and any(word in str(action.metavar) for word in ("FILE", "DIR", ".mcap"))
            if named and action.dest not in INPUTS[""] | INPUTS.get(command, set()):
                assert (command, action.dest) in known, f"{command} {action.option_strings}"
        if any(command == one for one, _ in known):
            assert any(action.dest == "overwrite" for action in parser._actions), command


def test_arguments_cover_every_command_with_an_output():
    assert {command for command, _ in OUTPUTS} == set(WORDS)


def words(command: str, option: str, path: Path) -> list[str]:
    needed = ["-o", str(path.with_name("new.png"))] if command == "screenshot" and option != "--output" else []
    return [command, *WORDS[command], *needed, option, str(path)]


def is_folder(command: str) -> bool:
    return command in ("compare", "study")


@pytest.mark.parametrize(("command", "option"), OUTPUTS)
def test_existing_file_is_not_replaced(command, option, tmp_path, capsys):
    path = tmp_path / "out.npz"
    path.write_bytes(b"precious")
    assert run_command(words(command, option, path), windows={}) == 1
    output = capsys.readouterr().err
    assert f"{path}: " in output
    assert ("the folder cannot be created" if is_folder(command) else "(--overwrite)") in output
    assert [(one.name, one.read_bytes()) for one in tmp_path.iterdir()] == [("out.npz", b"precious")]


@pytest.mark.parametrize("link", [False, True], ids=["same", "linked"])
@pytest.mark.parametrize(("command", "option"), [each for each in OUTPUTS if "in." in str(WORDS[each[0]])])
def test_input_file_is_never_replaced(command, option, link, tmp_path, capsys):
    (name,) = (word for word in WORDS[command] if word.startswith("in."))
    path = tmp_path / name
    output = tmp_path / "out" if link else tmp_path / name
    path.write_bytes(b"precious")
    if link:
        output.symlink_to(path)
    given = [str(path) if word == name else word for word in words(command, option, output)]
    assert run_command([*given, "--overwrite"], windows={}) == 1
    assert "a file that is read cannot be the output" in capsys.readouterr().err
    assert path.read_bytes() == b"precious"


def test_scene_file_is_not_replaced_by_its_recording(tmp_path, capsys):
    scene = tmp_path / "s.toml"
    scene.write_text('robot = "arm"')
    assert run_command(["run", str(scene), "--for", "0.1", "-o", str(scene), "--overwrite"], windows={}) == 1
    assert "a file that is read cannot be the output" in capsys.readouterr().err
    assert scene.read_text() == 'robot = "arm"'


@pytest.mark.sampled(13)
@pytest.mark.parametrize("kind", special_kinds())
@pytest.mark.parametrize(("command", "option"), OUTPUTS)
def test_special_file_is_rejected_even_with_overwrite(command, option, kind, tmp_path, capsys):
    path = make_special_file(kind, tmp_path / "out.npz")
    assert run_command([*words(command, option, path), "--overwrite"], windows={}) == 1
    assert f"a {kind}" in capsys.readouterr().err
    assert is_special(path)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("command", "option"), OUTPUTS)
@pytest.mark.parametrize("name", ["x" * 300, "no/folder/x.npz", "taken/x.npz"])
def test_unwritable_path_is_reported_immediately(command, option, name, tmp_path, capsys):
    if is_folder(command) and name.startswith("no"):
        return  # folders above it are made
    (tmp_path / "taken").write_bytes(b"")
    assert run_command(words(command, option, tmp_path / name), windows={}) == 1
    assert "cannot be" in capsys.readouterr().err
    assert [one.name for one in tmp_path.iterdir()] == ["taken"]


@pytest.mark.parametrize(("flag", "names"), [([], ["controllers.csv"]), ([], ["controllers.html"])])
def test_files_of_an_earlier_comparison_are_not_replaced(flag, names, tmp_path, capsys):
    for name in names:
        (tmp_path / name).write_bytes(b"precious")
    assert run_command([*words("compare", "--output", tmp_path), *flag], windows={}) == 1
    assert f"{tmp_path / names[0]}: the file already exists" in capsys.readouterr().err


@pytest.mark.parametrize("ending", ["csv", "json", "html", "parquet"])
def test_existing_report_is_not_replaced(ending, tmp_path, capsys):
    (tmp_path / f"map-cost.{ending}").write_bytes(b"precious")
    assert run_command(words("study", "--output", tmp_path), windows={}) == 1
    assert f"map-cost.{ending}: the file already exists" in capsys.readouterr().err
    assert (tmp_path / f"map-cost.{ending}").read_bytes() == b"precious"


def test_two_outputs_with_the_same_name_are_rejected(tmp_path, capsys):
    path = tmp_path / "out.mcap"
    assert (
        run_command(["listen", "in.csv", "--weight", "1", "-o", str(path), "--save-calibration", str(path)], windows={})
        == 2
    )
    assert "two outputs have the same name" in capsys.readouterr().err


@pytest.mark.parametrize(("command", "option"), [each for each in OUTPUTS if ending_of(*each)])
def test_name_of_another_format_is_rejected(command, option, tmp_path, capsys):
    assert run_command(words(command, option, tmp_path / "x.txt"), windows={}) == 1
    message = f"must end in {ending_of(command, option)} (found: .txt). Choose the name x{ending_of(command, option)}"
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("form", "name", "message"),
    [
        ("npz", "x.csv", "must end in .npz (found: .csv). Choose the name x.npz"),
        ("hdf5", "x.csv", "must end in .h5 or .hdf5 (found: .csv). Choose the name x.h5"),
        ("hdf5", "x.hdf5", "in.mcap"),
        ("npz", "x", "in.mcap"),
        ("csv", "x.y", "in.mcap"),
    ],
)
def test_name_of_an_export_has_an_ending_of_its_format(form, name, message, tmp_path, capsys):
    words = ["export", "in.mcap", "--to", form, "-o", str(tmp_path / name)]
    assert run_command(words, windows={}) == 1
    assert message in capsys.readouterr().err

"""``tactile-maps weigh``: exit codes, words and keys."""

from __future__ import annotations

import json

import pytest

from tactile_widgets.__main__ import main

SCENE = """robot = "arm"
[cover]
links = ["forearm"]
taxels = 150
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return str(path)


@pytest.mark.long
def test_calibrated_skin_reads_the_weight(capsys, scene):
    assert main(["weigh", scene, "--json"]) == 0
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert result["expected_N"] == pytest.approx(0.981)
    assert result["read_N"] == pytest.approx(0.981, rel=0.01)
    assert result["error"] == pytest.approx(result["read_N"] / 0.981 - 1)
    assert {"model": result["model"], "patch": result["patch"], "mass": result["mass"], "good": result["good"]} == {
        "model": "water-fill",
        "patch": "forearm",
        "mass": 0.1,
        "good": True,
    }
    assert 0 < result["seconds"] < 10


@pytest.mark.long
def test_given_weight_and_model_are_printed_and_written_to_a_page(capsys, scene, tmp_path):
    page = tmp_path / "page.html"
    assert main(["weigh", scene, "--mass", "0.5", "--model", "point", "--report", str(page)]) == 0
    out = capsys.readouterr().out
    assert str(page) in out
    assert "<td>0.5 kg, 4.905 N</td>" in page.read_text(encoding="utf8")
    assert "0.5 kg, 4.905 N" in out
    assert "with point" in out
    assert "passed" in out


@pytest.mark.long
def test_wrong_reading_exits_with_a_failure(capsys, scene):
    """MuJoCo's own taxels feel depth, not force."""
    assert main(["weigh", scene, "--model", "depth", "--json"]) == 1
    result = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert result.get("good") is False or "error" in result


@pytest.mark.parametrize(
    ("words", "output"),
    [
        (["--model", "watr-fill"], "water-fill"),
        (["--mass", "-1"], "above 0"),
        (["--mass", "heavy"], "mass"),
    ],
)
def test_invalid_arguments_are_usage_errors(capsys, scene, words, output):
    assert main(["weigh", scene, *words]) == 2
    assert output in capsys.readouterr().err


def test_unknown_robot_is_named(capsys):
    assert main(["weigh", "armm"]) == 1
    assert "armm" in capsys.readouterr().err

"""Errors say what a person can do; an unforeseen problem becomes a sentence and a file."""

from __future__ import annotations

import pickle
import re
from importlib import import_module
from pathlib import Path

import pytest

import tactile_maps
from tactile_maps.core.errors import (
    ExportError,
    Finding,
    LiveError,
    MeshError,
    RobotError,
    SkinError,
    TactileMapsError,
    UsageError,
    add_finding,
    check_range,
    counted,
    describe_unexpected_error,
    did_you_mean,
    errors_in_file,
    names_text,
    packages_of,
    places_finding,
    write_crash_log,
)
from tactile_maps.robots.library import load_robot
from tactile_maps.scene.scene import Scene
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.open import SkinOptions


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (MeshError("it is broken"), "it is broken."),
        (MeshError("it is broken", file="a.obj"), "a.obj: it is broken."),
        (
            RobotError("it is broken", file="a.obj", place="face 3", value=7, remedy="Mend it"),
            "a.obj, face 3: it is broken (found: 7). Mend it.",
        ),
        (UsageError("no", value=0), "no (found: 0)."),
        (LiveError("no", value=ConnectionRefusedError(111, "Connection refused")), "no (found: Connection refused)."),
    ],
)
def test_message_contains_place_value_and_remedy(error, text):
    assert str(error) == text


def test_long_value_is_shortened():
    assert len(str(TactileMapsError("no", value="x" * 10_000))) < 200
    assert "\n" not in str(TactileMapsError("no", value="a\nb"))


def test_pickled_error_is_complete():
    error = RobotError("it is broken", file="a.xml", place="line 1", value=[1], remedy="Mend it")
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is RobotError
    assert str(copy) == str(error)
    assert (copy.problem, copy.file, copy.place, copy.remedy) == ("it is broken", "a.xml", "line 1", "Mend it")


def _problem() -> ZeroDivisionError:
    try:
        return 1 // 0
    except ZeroDivisionError as error:
        return error


def test_crash_log_contains_the_traceback(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = write_crash_log(_problem())
    assert tmp_path in path.parents
    assert "_problem" in path.read_text()


def test_unexpected_error_is_described_in_one_sentence(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    text = describe_unexpected_error(_problem())
    assert "ZeroDivisionError" in text
    assert "crash" in text
    assert "\n" not in text


def test_unwritable_log_folder_is_reported(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    assert "could not be written" in describe_unexpected_error(_problem())


def test_at_returns_the_error_with_its_place():
    error = MeshError("it is broken", place="face 3", value=0, remedy="Mend it")
    moved = error.at(file="a.obj", place="mesh 1, face 3")
    assert type(moved) is MeshError
    assert str(moved) == "a.obj, mesh 1, face 3: it is broken (found: 0). Mend it."
    assert str(error) == "face 3: it is broken (found: 0). Mend it.", "the first is unchanged"
    other = error.at(kind=SkinError, problem="the skin is broken", value=False, remedy="Cover it again")
    assert type(other) is SkinError
    assert str(other) == "face 3: the skin is broken (found: False). Cover it again."


def test_missing_file_is_added_to_errors():
    with pytest.raises(SkinError, match=r"a\.txt, row 3: wrong \(found: 5\)\. Do\."), errors_in_file("a.txt"):
        raise SkinError("wrong", place="row 3", value=5, remedy="Do")
    with pytest.raises(SkinError, match=r"b\.txt: wrong"), errors_in_file("a.txt"):
        raise SkinError("wrong", file="b.txt")


def test_finding_without_occurrences_is_not_added():
    findings: list[Finding] = []
    add_finding(findings, "kind", "where", "action", 0)
    add_finding(findings, "kind", "where", "action", 3)
    assert findings == [Finding("kind", "where", "action", 3)]


def test_finding_of_many_places_names_the_first_ones():
    assert places_finding("kind", [], "action") == []
    assert places_finding("kind", ["a", "b"], "action", count=3) == [Finding("kind", "a, b", "action", 3)]
    assert places_finding("kind", list("abcdefg"), "action", separator="; ") == [
        Finding("kind", "a; b; c; d; e, …", "action", 7)
    ]


def test_installed_module_is_imported_and_missing_one_is_named():
    with packages_of("export"):
        assert import_module("json")
    with (
        pytest.raises(ExportError, match=r"no_such_package.*-m pip install .*'pyarrow>=16'"),
        packages_of("export"),
    ):
        import_module("no_such_package.inner")


def test_every_remedy_states_the_command_for_this_environment():
    sources = [path for path in Path(tactile_maps.__file__).parent.rglob("*.py") if path.name != "parser.py"]
    generic = re.compile(r"pip install '?tactile-maps\[")
    assert [path.name for path in sources if generic.search(path.read_text(encoding="utf8"))] == []


@pytest.mark.parametrize(
    ("build", "place"),
    [
        (lambda: CoverSpec(links="hand"), "links"),
        (lambda: CoverSpec(bare="hand"), "bare"),
        (lambda: SkinOptions(links="hand"), "links"),
        (lambda: SkinOptions(package_roots="here"), "package_roots"),
        (lambda: Scene("touch", robot="arm", outputs="force"), "outputs"),
        (lambda: Scene("touch", robot="arm", package_roots="here"), "package_roots"),
        (lambda: Scene("touch", robot="arm", taxel_files="skin.csv"), "taxel_files"),
        (lambda: load_robot("arm", package_roots=Path("here")), "package_roots"),
    ],
)
def test_single_name_in_place_of_several_is_rejected_with_the_sequence(build, place):
    with pytest.raises(TactileMapsError, match=rf'{place}.*a single name.*{place}=\("[a-z.]+",\)'):
        build()


@pytest.mark.parametrize(
    ("word", "known", "remedy"),
    [
        ("Frction", ("friction", "skin"), "Did you mean friction? Choose one of: friction, skin"),
        ("leftarm", ("LeftArm", "Torso"), "Did you mean LeftArm? Choose one of: LeftArm, Torso"),
        ("tab", ("tap", "slip"), "Did you mean tap? Choose one of: tap, slip"),
        ("degrees", ("deg", "rad"), "Did you mean deg? Choose one of: deg, rad"),
        ("foo", ("robot", "cover"), "Choose one of: robot, cover"),
        ("bar", ("layer",), "Choose one of: layer"),
        ("camera", ("name",), "Choose one of: name"),
        ("friction", ("description",), "Choose one of: description"),
        ("abroad", ("a", "rb"), "Choose one of: a, rb"),
        ("foo", (), "There are none"),
    ],
)
def test_remedy_names_only_a_word_of_similar_spelling(word, known, remedy):
    assert did_you_mean(word, known) == remedy


@pytest.mark.parametrize(
    ("number", "noun", "text"),
    [
        (1, "patch", "1 patch"),
        (0, "patch", "0 patches"),
        (2, "flipped mesh", "2 flipped meshes"),
        (3, "damaged copy", "3 damaged copies"),
        (2, "key", "2 keys"),
        (21, "taxel", "21 taxels"),
    ],
)
def test_noun_is_in_the_plural_unless_there_is_one(number, noun, text):
    assert counted(number, noun) == text


@pytest.mark.parametrize(("count", "end"), [(8, "n7"), (9, "n7 and 1 more")])
def test_long_lists_are_shortened(count, end):
    assert names_text([f"n{number}" for number in range(count)]).endswith(end)


@pytest.mark.parametrize("value", [-0.1, 2.5, float("nan"), float("inf"), True, "1"])
def test_value_out_of_range_is_refused_with_its_unit_and_limits(value):
    check_range("the pitch", 2.0, 0, 2, error=SkinError, unit="mm")
    with pytest.raises(SkinError, match=r"pitch: the pitch is out of range \(found: .*\)\. Choose 0 to 2 mm"):
        check_range("the pitch", value, 0, 2, error=SkinError, place="pitch", unit="mm")

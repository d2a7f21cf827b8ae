"""Files by strangers: bounded, inside, without XML tricks."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import Finding, RobotError
from tactile_maps.robots.files import safe_files
from tactile_maps.robots.files.safe_files import parse_model_xml, parse_xml, read_bytes, resolve_inside


def test_folder_missing_and_large_files_have_different_errors(tmp_path, monkeypatch):
    with pytest.raises(RobotError, match="folder, not a file"):
        read_bytes(tmp_path)
    with pytest.raises(RobotError, match="no such file"):
        read_bytes(tmp_path / "absent.xml")
    monkeypatch.setattr(safe_files, "MAX_BYTES", 3)
    (tmp_path / "large").write_bytes(b"1234")
    with pytest.raises(RobotError, match="larger than"):
        read_bytes(tmp_path / "large")
    (tmp_path / "small").write_bytes(b"123")
    assert read_bytes(tmp_path / "small") == b"123"


def test_impossible_file_name_is_rejected(tmp_path):
    with pytest.raises(RobotError):
        read_bytes(tmp_path / ("x" * 5000))


def test_xml_with_too_many_elements_is_rejected(tmp_path, monkeypatch):
    monkeypatch.setattr(safe_files, "MAX_ELEMENTS", 2)
    assert parse_xml(b"<a><b/></a>", file=tmp_path).tag == "a"
    with pytest.raises(RobotError, match="elements"):
        parse_xml(b"<a><b/><b/></a>", file=tmp_path)


def test_xml_nested_too_deep_is_rejected(tmp_path):
    assert parse_xml(b"<a>" * 200 + b"</a>" * 200, file=tmp_path).tag == "a"
    with pytest.raises(RobotError, match="deep"):
        parse_xml(b"<a>" * 100_000 + b"</a>" * 100_000, file=tmp_path)


@pytest.mark.parametrize("data", [b"", b"<a>", b"\xff\xfe\x00", b'<?xml version="1.0" encoding="no-such"?><a/>'])
def test_other_content_than_xml_is_rejected(tmp_path, data):
    with pytest.raises(RobotError, match="not valid XML"):
        parse_xml(data, file=tmp_path / "x.xml")


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"<a><b/></a>\r\n\0\0", "zero bytes"),
        (b'\n <!-- made by -- hand --><?xml version="1.0"?><a><b/></a>', "comments"),
        (b'<?xml version="1.0"?><a><!-- gr\xf6\xdfe --><b/></a>', "comments"),
        (b'<a name="gr\xf6\xdfe"><b/></a>', "Latin-1"),
        (b"<a><gazebo:b/><b drake:c='1'/></a>", "prefixes were not declared: drake, gazebo"),
    ],
)
def test_parts_without_meaning_are_repaired_and_reported(data, what):
    findings: list[Finding] = []
    assert parse_model_xml(data, file="r.urdf", findings=findings).find("b") is not None
    assert [finding.kind for finding in findings] == ["xml-repaired"]
    assert what in findings[0].action


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"<a>",
        b"\xff\xfe\x00",
        b"<a>\0</a>",
        b'<?xml version="1.0" encoding="no-such"?><a/>',
        b"<a><b></a>\0",
        b'<!-- x --><!DOCTYPE m [<!ENTITY a "b">]><a>&a;</a>',
        b'\0<!DOCTYPE<!-- --> m [<!ENTITY a "b">]><a>&a;</a>',
    ],
)
def test_broken_or_unsafe_documents_are_rejected_after_repairs(data):
    with pytest.raises(RobotError):
        parse_model_xml(data, file="r.urdf")


def test_names_lose_their_namespace_except_xacros():
    root = parse_model_xml(b'<robot xmlns="u" xmlns:xacro="http://x/xacro"><link/><xacro:if/></robot>', file="r.urdf")
    assert [root.tag, *(child.tag for child in root)] == ["robot", "link", "{http://x/xacro}if"]


def test_path_outside_its_roots_is_rejected(tmp_path):
    assert resolve_inside(tmp_path / "a" / ".." / "b", [tmp_path], file=tmp_path, named="b") == tmp_path.resolve() / "b"
    with pytest.raises(RobotError, match="leaves the robot"):
        resolve_inside(tmp_path / "..", [tmp_path], file=tmp_path, named="..")
    with pytest.raises(RobotError, match="cannot be followed"):
        resolve_inside(tmp_path / "nul\0", [tmp_path], file=tmp_path, named="nul")

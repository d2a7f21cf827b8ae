from __future__ import annotations

import pytest

from app.core.errors import Finding, MapError, SkinError
from app.skin.formats.foreign_file import add_finding, errors_in_file, read_bytes, read_text, write_bytes, write_lines


def test_files_are_read_whole_and_bounded(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"\xef\xbb\xbfx\xff")
    assert read_text(path) == "x\ufffd"
    with pytest.raises(MapError, match="file.*too large.*5 bytes"):
        read_bytes(path, most=4, error=MapError)
    for missing in (tmp_path / "nowhere", tmp_path):
        with pytest.raises(SkinError, match="cannot be read"):
            read_bytes(missing)


def test_files_are_written_whole_or_not_at_all(tmp_path):
    write_lines(tmp_path / "file", ["one", "two \ud800"])
    assert (tmp_path / "file").read_bytes() == b"one\ntwo ?\n"
    write_bytes(tmp_path / "file", b"new")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    with pytest.raises(MapError, match="cannot be written.*folder you may write to"):
        write_bytes(tmp_path / "no" / "file", b"", error=MapError)


def test_errors_get_the_file_they_lack():
    with pytest.raises(SkinError, match=r"a\.txt, row 3: wrong \(found: 5\)\. Do\."), errors_in_file("a.txt"):
        raise SkinError("wrong", place="row 3", value=5, remedy="Do")
    with pytest.raises(SkinError, match=r"b\.txt: wrong"), errors_in_file("a.txt"):
        raise SkinError("wrong", file="b.txt")


def test_only_what_is_there_is_noted():
    findings: list[Finding] = []
    add_finding(findings, "kind", "where", "action", 0)
    add_finding(findings, "kind", "where", "action", 3)
    assert findings == [Finding("kind", "where", "action", 3)]

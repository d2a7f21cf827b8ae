from __future__ import annotations

from pathlib import Path

import pytest

from app.errors import SkinError
from app.skin.exchange import text_rows
from app.skin.exchange.text_rows import read_rows


def written(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "left_part.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_header_list_and_rows(tmp_path: Path) -> None:
    text = "name\t l_part\r\nspatial_sampling taxel\r\ntaxel2Repr ( 1 1 -2\t-1 )\r\n[calibration]\r\n"
    rows = read_rows(written(tmp_path, text + "0.1 0.2 0.3\t1 0 0\r\n\r\n0 0 0 0 0 0 \r\n"))
    assert rows.name == "l_part"
    assert rows.representatives is not None
    assert rows.representatives.tolist() == [1, 1, -2, -1]
    assert rows.values.tolist() == [[0.1, 0.2, 0.3, 1, 0, 0], [0, 0, 0, 0, 0, 0]]


def test_rows_alone_with_comments_and_no_last_line_end(tmp_path: Path) -> None:
    rows = read_rows(written(tmp_path, "// made by hand\n# too\n0 0 0.1\n1e-2 -.5 0.2"))
    assert (rows.name, rows.representatives) == (None, None)
    assert rows.values.tolist() == [[0, 0, 0.1], [0.01, -0.5, 0.2]], "the last row counts"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no taxel rows"),
        ("name part\n", "no taxel rows"),
        ("0 0 1\n0 0\n", "line 2.*3 or 6 numbers.*found: 0 0"),
        ("0 0 1\n0 0 1 2\n", "line 2.*3 or 6"),
        ("0 0 1\n0 0 1 0 0 1\n", "line 2.*have 3 numbers"),
        ("0 0 1\n0 x 1\n", "line 2.*3 or 6.*0 x 1"),
        ("0 0 1\nxyz 0 1\n", "line 2.*3 or 6"),
        ("0 0 nan\n", "line 1.*not finite"),
        ("0 0 1\n0 inf 1\n", "line 2.*not finite"),
        ("30.8 66.9 23.5\n", "line 1.*positions are in metres.*30.8"),
        ("taxel2Repr 1 2 3\n0 0 1\n", "line 1.*list in brackets"),
        ("taxel2Repr ( 1 two )\n0 0 1\n", "line 1.*taxel number.*two"),
        ("taxel2Repr ( -3 )\n0 0 1\n", "taxel number.*-3"),
        ("taxel2Repr ( 99999999999999999999 )\n0 0 1\n", "taxel number"),
        ("taxel2Repr ( 0 7 )\n0 0 1\n", "does not exist.*7"),
        (b"\x80\x04\x95pickle\x00\n", "no taxel rows"),
    ],
)
def test_broken_files_are_refused_with_line_and_value(tmp_path: Path, text: str | bytes, problem: str) -> None:
    with pytest.raises(SkinError, match=f"left_part.txt.*{problem}"):
        read_rows(written(tmp_path, text))


def test_absurd_sizes_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path, "0 0 1\n" * 20)
    monkeypatch.setattr(text_rows, "MAX_ROWS", 10)
    with pytest.raises(SkinError, match="line 11.*more than 10 rows"):
        read_rows(path)
    with pytest.raises(SkinError, match="more than 10 entries"):
        read_rows(written(tmp_path, f"taxel2Repr ( {'1 ' * 11})\n0 0 1\n"))
    monkeypatch.setattr(text_rows, "MAX_BYTES", 10)
    with pytest.raises(SkinError, match="too large"):
        read_rows(path)


def test_a_missing_file_and_a_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(SkinError, match="cannot be read"):
        read_rows(tmp_path / "nowhere.txt")
    with pytest.raises(SkinError, match="cannot be read"):
        read_rows(tmp_path)

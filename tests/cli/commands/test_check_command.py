"""``check``: a recorded or live skin is checked part by part, and faulty channels are listed on a page."""

from __future__ import annotations

import io
import json
import re
import threading
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.cli.commands.check import Keys
from tactile_maps.live.checking.parts import parts_of
from tactile_maps.live.checking.skin_check import CheckStage, Outcome, SkinCheck
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import save_map
from tactile_widgets.__main__ import main
from tests.support.pressed_stream import pressed, skin_with_modules

SKIN = skin_with_modules()
PARTS = [part.taxels for part in parts_of(SKIN)]
DEAD = int(PARTS[1][4])
SWAPPED = [int(PARTS[0][3]), int(PARTS[3][4])]


@pytest.fixture(scope="module")
def skin(tmp_path_factory):
    path = tmp_path_factory.mktemp("skin") / "modules.npz"
    save_map(build_map(SKIN), path)
    return str(path)


def written(path, parts=PARTS, **stream):
    """Write readings in which the parts are pressed, with a dead channel and two swapped ones."""

    def change(values, number):
        values[SWAPPED] = values[SWAPPED[::-1]]
        values[DEAD] = 200.0
        return values

    lines = ["time," + ",".join(map(str, SKIN.identity.ids))]
    lines += [f"{time}," + ",".join(map(str, values)) for values, time in pressed(SKIN, parts, change=change, **stream)]
    path.write_text("\n".join(lines))
    return str(path)


def test_recorded_check_gives_numbers_and_a_self_contained_page(skin, tmp_path, capsys):
    report = tmp_path / "check.html"
    source = written(tmp_path / "a <b>.csv")
    words = ["check", source, "--skin", skin, "--order", "asked", "--report", str(report), "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["outcomes"]["felt"] == 4
    assert {one["taxel"]: one["faults"] for one in found["channels"]} == {
        DEAD: ["dead"],
        **{taxel: ["swapped"] for taxel in SWAPPED},
    }
    assert found["swapped"] == ["id 113, module 10, channel 10 with id 115, module 13, channel 8"]
    page = report.read_text(encoding="utf8")
    assert not re.search(r"<script|<link|https?://|src=", page)
    for text in ("a &lt;b&gt;.csv", "module 11", "1 dead, 2 swapped", "as requested", skin, "counts", "<svg"):
        assert text in page
    circles = np.array(re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)"', page), dtype=float)
    assert len(circles) == len(SKIN)
    box = np.array(re.findall(r'viewBox="0 0 (\d+) (\d+)"', page)[0], dtype=float)
    assert (circles < box).all()
    assert 0.9 < np.ptp(circles, axis=0).max() / box.max() < 1
    assert main(words) == 1
    assert "exists" in capsys.readouterr().err


def test_file_of_any_touches_is_the_default_of_a_file(skin, tmp_path, capsys):
    assert main(["check", written(tmp_path / "any.csv", [PARTS[2], PARTS[1]], gap=0.2), "--skin", skin]) == 0
    captured = capsys.readouterr()
    assert re.search(r"Touches +1; pauses below 0\.3 s do not separate touches", captured.out)
    assert re.search(r"Parts +2 not checked|Parts +.*2 felt", captured.out)
    assert re.search(r"module 11, channel \d+ +dead", captured.out)
    assert "warning" not in captured.err


def test_channels_are_not_checked_where_nothing_was_pressed(skin, tmp_path, capsys):
    report = tmp_path / "check.html"
    assert main(["check", written(tmp_path / "rest.csv", []), "--skin", skin, "--report", str(report)]) == 0
    text = "not checked: nothing was pressed"
    assert re.search(rf"Channels +{text}", capsys.readouterr().out)
    assert text in report.read_text(encoding="utf8")


def test_end_of_the_source_before_all_parts_is_a_warning_and_before_the_rest_an_error(skin, tmp_path, capsys):
    source = written(tmp_path / "short.csv", PARTS[:2])
    assert main(["check", source, "--skin", skin, "--order", "asked"]) == 0
    assert "the readings ended before 2 of 4 parts had their turn" in capsys.readouterr().err
    assert main(["check", source, "--skin", skin, "--rest", "100"]) == 1
    assert "the readings ended before the skin at rest was measured" in capsys.readouterr().err


def test_live_skin_is_checked_in_order_and_settings_have_a_range(skin, capsys):
    assert main(["check", "udp:", "--skin", skin, "--order", "any"]) == 2
    assert "a live skin is checked part by part" in capsys.readouterr().err
    assert main(["check", "readings.csv", "--skin", skin, "--threshold", "0"]) == 2
    assert main(["check", "readings.csv", "--skin", skin, "--patience", "5"]) == 2
    assert "--patience" in capsys.readouterr().err


def test_prompts_and_keys_guide_through_the_parts(monkeypatch, capsys):
    check = SkinCheck(SKIN)
    texts = [check.prompt]
    for values, time in pressed(SKIN, [PARTS[3], PARTS[0][:6]], gap=1.0):
        check.add(values, time)
        texts += [check.prompt] if check.prompt != texts[-1] else []
    assert texts == [
        "leave the skin untouched for 2 s",
        "press module 10 (1 of 4)",
        "Module 13 responded instead. Press module 10 (1 of 4)",
        "module 10: 6 of 12 taxels are not felt yet; press them, or wait",
    ]
    monkeypatch.setattr("sys.stdin", io.StringIO("\ns\nx\nb\n\nq\n"))
    keys = Keys()
    for thread in threading.enumerate():
        if thread.name == "keys":
            thread.join()
    assert keys.apply(check)
    assert "unknown key" in capsys.readouterr().err
    assert [one.outcome for one in check.results] == [Outcome.FELT, Outcome.NOTHING, Outcome.OPEN, Outcome.OPEN]
    assert (check.stage, check.current) == (CheckStage.PRESS, 2)


@pytest.mark.long
def test_readings_of_a_part_of_the_skin_are_a_warning(skin, tmp_path, capsys):
    path = tmp_path / "half.csv"
    rows = [line.split(",") for line in Path(written(path)).read_text().splitlines()]
    path.write_text("\n".join(",".join(row[: 1 + len(SKIN) // 2]) for row in rows))
    assert main(["check", str(path), "--skin", skin]) == 0
    message = capsys.readouterr().err
    assert f"values of only {len(SKIN) // 2} of the skin's {len(SKIN)} taxels; they may be of another skin" in message

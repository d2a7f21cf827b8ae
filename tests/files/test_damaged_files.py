"""Whatever is changed in a file, it is read or rejected by name: no traceback, no hang, nothing left open."""

from __future__ import annotations

import re
from collections import Counter

import pytest

from tests.files import damaged_files

DEFAULT = 200
ALL = 50_000
MEMORY = 2 * 2**30


@pytest.mark.parametrize("first", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(500, ALL, 5500))])
def test_damaged_files_are_read_or_rejected_by_name(first, call_all):
    numbers = range(first, min(first + (DEFAULT if not first else 5500), ALL))
    outcomes = call_all(damaged_files.try_case, [(number,) for number in numbers], cpu=8.0, memory=MEMORY)
    assert len(outcomes) == len(numbers)
    wrong = [
        f"{number}: {outcome}"
        for number, outcome in zip(numbers, outcomes, strict=True)
        if not outcome.startswith(("ok", "refused: "))
    ]
    assert not wrong, "\n".join(wrong)
    kinds = Counter(outcome[:2] for outcome in outcomes)
    assert kinds["re"] > len(numbers) / 4, kinds
    assert kinds["ok"] > len(numbers) / 20, kinds


@pytest.mark.long
def test_files_are_valid_before_they_are_damaged(tmp_path):
    for name, (opener, ending, data) in damaged_files.seeds().items():
        path = tmp_path / f"{name.replace('.', ' ')}{ending}"
        path.write_bytes(data)
        damaged_files.read(opener, str(path))


@pytest.mark.long
def test_seed_gives_the_same_file_again():
    for name in ("map", "mjcf", "recording"):
        assert damaged_files.damaged(name, 7) == damaged_files.damaged(name, 7)
        assert damaged_files.damaged(name, 7) != damaged_files.damaged(name, 8)


@pytest.mark.long
def test_exceeded_limits_are_detected(call_all):
    ways = ("fine", "hang", "grow", "leak", "crash", "fail", "refuse", "fine")
    outcomes = call_all(damaged_files.misbehave, [(way,) for way in ways], cpu=0.5, memory=MEMORY)
    words = (
        "ok",
        "killed by SIGPROF",
        "traceback: .*Memory",
        "leaked 1 desc",
        "killed by SIGABRT",
        "traceback: KeyError",
        "refused: refuse",
        "ok",
    )
    for word, outcome in zip(words, outcomes, strict=True):
        assert re.match(word, outcome), (word, outcome)

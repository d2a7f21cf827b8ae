"""Files that state or repeat too much are read or refused by name, within 10 CPU seconds and 1 GB."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.files import amplified_files
from tests.files.small_bombs import CPU_SECONDS

pytestmark = pytest.mark.long

DEFAULT = 30
ALL = 5_030


@pytest.mark.parametrize("first", [0, *(pytest.param(n, marks=pytest.mark.long) for n in range(DEFAULT, ALL, 1000))])
def test_amplified_files_are_read_or_rejected_by_name(first, call_all):
    numbers = range(first, first + (DEFAULT if not first else 1000))
    outcomes = call_all(amplified_files.try_case, [(number,) for number in numbers], cpu=CPU_SECONDS)
    wrong = [
        f"{number}: {outcome}"
        for number, outcome in zip(numbers, outcomes, strict=True)
        if not outcome.startswith(("ok", "refused: "))
    ]
    assert not wrong, "\n".join(wrong)
    kinds = Counter(outcome[:2] for outcome in outcomes)
    assert min(kinds["re"], kinds["ok"]) > len(numbers) / 20, kinds


@pytest.mark.long
def test_seed_gives_the_same_file_again():
    for name in ("map", "mjcf", "recording", "mesh.glb"):
        assert amplified_files.amplified(name, 7) == amplified_files.amplified(name, 7)
        assert amplified_files.amplified(name, 7) != amplified_files.amplified(name, 8)

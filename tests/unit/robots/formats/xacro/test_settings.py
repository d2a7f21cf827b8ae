"""YAML that a xacro reads: plain values, quantities in SI; nothing that makes objects or swells."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from app.core.errors import RobotError
from app.robots.formats.xacro.settings import parse_settings

pytest.importorskip("yaml")
FILE = Path("limits.yaml")


def test_values_and_units() -> None:
    data = b"hip:\n  upper: !degrees 180\n  names: [a, b]\n  far: !inches 1\n"
    assert parse_settings(data, FILE) == {"hip": {"upper": pytest.approx(math.pi), "names": ["a", "b"], "far": 0.0254}}


@pytest.mark.parametrize(
    "data",
    [
        b"a: !!python/object/apply:os.system ['true']", b"a: &x [1]\nb: *x", b"a: [", b"a: !degrees many",
        b"[" * 5000, b"a" * (2**20 + 1), b"\xff\xfe\xfd", b"a: 1\n---\nb: 2\n",
    ],
)  # fmt: skip
def test_objects_aliases_and_broken_files_are_refused_without_quoting_them(data: bytes) -> None:
    with pytest.raises(RobotError, match=r"limits\.yaml") as found:
        parse_settings(data, FILE)
    assert "many" not in str(found.value)

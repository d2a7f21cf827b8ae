"""YAML that a xacro reads: plain values, quantities in SI; nothing that makes objects or swells."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.files.plain_yaml import parse_yaml

pytest.importorskip("yaml")
FILE = Path("limits.yaml")


def test_values_and_units_are_read():
    data = b"hip:\n  upper: !degrees 180\n  names: [a, b]\n  far: !inches 1\n"
    assert parse_yaml(data, FILE) == {"hip": {"upper": pytest.approx(math.pi), "names": ["a", "b"], "far": 0.0254}}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"a: !!python/object/apply:os.system ['true']", "line 1.*a tag or key that is not supported"),
        (b"a: &x [1]\nb: *x", "several documents, or an alias"),
        (b"a: 1\nb: [", "line 2.*lists, keys or indentation"),
        (b"a: !degrees many", "a number that cannot be read"),
        (b"a: " + b"9" * 5000, "a number that cannot be read"),
        (b"[" * 5000, "nested too deep"),
        (b"a" * (2**20 + 1), "too large"),
        (b"\xff\xfe\xfd", "characters that YAML does not allow"),
        (b"a: 1\n---\nb: 2\n", "several documents, or an alias"),
    ],
)
def test_objects_aliases_and_broken_files_are_rejected_without_quoting_them(data, reason):
    with pytest.raises(RobotError, match=rf"limits\.yaml.*{reason}") as found:
        parse_yaml(data, FILE)
    assert "many" not in str(found.value)
    assert "Error" not in str(found.value), "no name of a class of Python"

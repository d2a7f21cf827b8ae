"""Numbers with units: the SI number to write instead is told."""

from __future__ import annotations

import math

import pytest

from app.toml.units import as_float, number_instead


@pytest.mark.parametrize(("text", "told"), [
    ("5 mm", "Lengths are in metres: write 0.005"), ("1.5cm", "write 0.015"), ("250 g", "kilograms: write 0.25"),
    ("-3e2 ms", "seconds: write -0.3"), ("20 kN/m", "newtons per metre: write 20000"),
    (".1 MPa", "pascals: write 100000"),
    ("50 Hz", "hertz: write 50"), ("180 deg", "radians: write 3.14159265359"), ("12", "Write 12, without quotes"),
    ("5 furlongs", "no such unit"), ("5 kpa", "Did you mean kPa"), ("soon", "Write a number, without quotes"),
    ("", "Write a number"), ("1 2", "Write a number"),
])  # fmt: skip
def test_what_to_write(text, told):
    assert told.lower() in number_instead(text).lower()


def test_numbers_of_any_size():
    assert as_float(3) == 3.0
    assert as_float(10**400) == math.inf
    assert as_float(-(10**400)) == -math.inf


def test_where_angles_are_in_degrees():
    assert "write 90" in number_instead("90 deg", degrees=True)

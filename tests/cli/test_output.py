"""Readable output of the command line: aligned, and numbers without the noise of binary fractions."""

from __future__ import annotations

import pytest

from tactile_maps.cli.shared.output import plain_text, print_fields


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.3400000000000034, "0.34"),
        (1234.5678, "1235"),
        (1e-9, "1e-09"),
        (float("nan"), "nan"),
        (12, "12"),
        (123456, "123456"),
        ("some text", "some text"),
        (["a", 0.1 + 0.2], "a, 0.3"),
        ({"angle": {"median": 1.0000000001, "max": 2.0}, "faces": 3}, "angle median 1, max 2, faces 3"),
    ],
)
def test_numbers_have_four_digits_and_thousands_separators(value, text):
    assert plain_text(value) == text


def test_fields_are_printed_in_two_columns(capsys):
    print_fields({"Seconds": 0.3400000000000034, "On": "arm"})
    assert capsys.readouterr().out == "Seconds  0.34\nOn       arm\n"

"""Error messages as sentences: a capital letter, except for names of files, addresses and identifiers."""

from __future__ import annotations

import pytest

from tactile_widgets.common.sentence import as_sentence


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("this address is open.", "This address is open."),
        ("Saved map.npz", "Saved map.npz"),
        ("readings.csv: no such file.", "readings.csv: no such file."),
        ("udp://127.0.0.1: cannot be opened.", "udp://127.0.0.1: cannot be opened."),
        ("upper_arm has no taxels.", "upper_arm has no taxels."),
        ("", ""),
    ],
)
def test_message_becomes_a_sentence(text, sentence):
    assert as_sentence(text) == sentence

"""The estimators' names are words of scenes and commands."""

from __future__ import annotations

import re

from app.contacts.estimators.names import ESTIMATORS


def test_they_are_plain_words_and_the_usual_one_comes_first():
    assert ESTIMATORS[0] == "area-sum"
    assert len(set(ESTIMATORS)) == len(ESTIMATORS)
    assert all(re.fullmatch("[a-z]+(-[a-z]+)*", name) for name in ESTIMATORS)

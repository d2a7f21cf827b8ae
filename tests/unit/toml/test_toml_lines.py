"""Values written as TOML read back as they were."""

from __future__ import annotations

import math
import tomllib

from hypothesis import given
from hypothesis import strategies as st

from app.toml.lines import toml_lines, toml_value

PLAIN = st.one_of(st.text(st.characters(exclude_categories=["Cs"])), st.booleans(), st.integers(-(2**62), 2**62),
                  st.floats(allow_nan=False))  # fmt: skip
VALUES = st.recursive(PLAIN, lambda inner: st.one_of(
    st.lists(inner, max_size=3), st.dictionaries(st.text(st.characters(exclude_categories=["Cs"])), inner, max_size=3),
), max_leaves=8)  # fmt: skip


@given(st.dictionaries(st.text(st.characters(exclude_categories=["Cs"])), VALUES, max_size=5))
def test_what_is_written_is_read(values):
    assert tomllib.loads(toml_lines(values)) == values


def test_tuples_become_lists_and_floats_stay_floats():
    assert toml_value((1.0, (2, "x"))) == '[1.0, [2, "x"]]'
    assert tomllib.loads(f"x = {toml_value(1e300)}")["x"] == 1e300
    assert tomllib.loads(f"x = {toml_value(math.inf)}")["x"] == math.inf

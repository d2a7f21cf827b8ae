"""The table of contacts: every row has the verdict that mechanics demands, or is a known exception with its reason."""

from __future__ import annotations

import pytest

from tactile_maps.studies.sweeps.contact import OK, OUTSIDE, REJECTED, cases, exception_of, measure

_KEYS = ("check", "skin", "shape", "physics", "motion", "integrator", "timestep_ms", "ratio")
CASES = cases(False, 0)


def name(case) -> str:
    return " ".join(str(case[key]) for key in _KEYS)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("case", CASES, ids=name)
def test_contact_obeys_mechanics(case):
    """A known exception that has become right fails here too, so that the list of exceptions can only shrink."""
    for measured in measure(case):
        row = {**case, **measured}
        expected = {OK, REJECTED} if exception_of(row) is None else {OUTSIDE}
        assert row["verdict"] in expected, row
        if row["verdict"] == REJECTED:
            assert row["timestep_ms"] == 4.0 or row["check"] in ("stick", "slip"), row["note"]

"""The list of mutations names existing code and tests; ``python -m tests.mutate`` checks that tests detect them."""

from __future__ import annotations

from tests.mutate import mutations


def test_there_are_many_over_the_important_packages():
    listed = mutations()
    assert len(listed) >= 40
    assert len({mutation.what for mutation in listed}) == len(listed)
    packages = {"/".join(mutation.file.split("/")[:3]) for mutation in listed}
    assert len(packages) >= 15


def test_each_can_be_made():
    assert not [f"{mutation.what}: {mutation.problem()}" for mutation in mutations() if mutation.problem()]

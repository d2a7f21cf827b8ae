"""The list of mutations names existing code and tests; ``python -m tests.mutate`` checks that tests detect them."""

from __future__ import annotations

from tests.mutate import mutations


def test_important_packages_have_many_mutations():
    listed = mutations()
    assert len(listed) >= 40
    assert len({mutation.what for mutation in listed}) == len(listed)
    packages = {"/".join(mutation.file.split("/")[:3]) for mutation in listed}
    assert len(packages) >= 15


def test_every_mutation_can_be_applied():
    assert not [f"{mutation.what}: {mutation.problem()}" for mutation in mutations() if mutation.problem()]

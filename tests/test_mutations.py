"""The list of mutations names existing code and tests, and the default tests detect a random tenth of it.

``python -m tests.mutate`` runs the others.
"""

from __future__ import annotations

import pytest

from tests.mutate import Mutation, copy_tree, mutations, outcome, random_tenth

SEED = 29


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return copy_tree(tmp_path_factory.mktemp("tree"))


def test_important_packages_have_many_mutations():
    listed = mutations()
    assert len(listed) >= 40
    assert len({mutation.what for mutation in listed}) == len(listed)
    packages = {"/".join(mutation.file.split("/")[:3]) for mutation in listed}
    assert len(packages) >= 15


def test_every_mutation_can_be_applied():
    assert not [f"{mutation.what}: {mutation.problem()}" for mutation in mutations() if mutation.problem()]


@pytest.mark.long
@pytest.mark.parametrize("mutation", [pytest.param(drawn, id=drawn.what) for drawn in random_tenth(SEED)])
def test_mutation_of_the_random_tenth_is_detected(mutation: Mutation, tree):
    assert outcome(mutation, tree).startswith("killed")

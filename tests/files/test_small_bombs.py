"""Small files that would expand to gigabytes or minutes of work are refused by name, or read within limits."""

from __future__ import annotations

import re

import pytest

from tests.files import small_bombs
from tests.files.small_bombs import BOMBS, CPU_SECONDS, LONG

MAKING = 6.0
"""CPU seconds for making the largest of the files: they are made in the process that reads them."""
EXPECTED = {
    "glb count without view": "implausible size.*1000000000",
    "glb sparse": "implausible size",
    "glb overlapping": "count of all meshes: .*implausible size",
    "glb instances": "count of all nodes: .*implausible size",
    "glb many instances": "more than 10000 nodes",
    "glb names": "more than 10000 meshes",
    "glb texture": "ok",
    "obj shared": "ok",
    "obj edge fan": "ok",
    "stl solids": "ok",
    "stl zeros": "no triangles",
    "dae doubling": "more than 10000 parts",
    "dae loop": "shows itself",
    "toml dots": "line 2: a key has too many parts",
    "toml header dots": "line 2: a key has too many parts",
    "toml lists": "lists or tables are nested too deep",
    "toml tables": "lists or tables are nested too deep",
    "toml stimuli": "more than 20000 stimuli",
    "scene objects": "more than 200 objects",
    "json deep": "lists and objects are nested too deep",
    "json digits": "a whole number has too many digits",
    "csv links": "more than 1000 links.*99000",
    "csv wide": "more than 1000 columns",
    "skin of taxels": "too many separate pieces.*The maximum is 2000",
    "skin of a tube of taxels": "ok",
    "taxels on one place": "nearly the same place",
    "npz zeros": "implausible size",
    "npz taxels": "implausible size",
    "npz rows": "positions.npy: an array has too many rows.*12582912.*100,000",
    "npz rows of a skin": "0_positions.npy: an array has too many rows.*12582912.*1,000,000",
    "mjcf 4900 classes": "more than 500 classes of defaults",
    "mjcf 499 classes": "ok",
    "mjcf nested classes": "ok",
    "mjcf sites of a link": "ok",
    "mjcf sites with sensors": "ok",
    "mjcf lights and keys": "ok",
    "mjcf scenery": "ok",
    "mjcf uses of a mesh": "link .*: the shapes of its links have more than 5 million triangles together.*25088000",
    "mjcf ring of vertices": "ok",
    "xml comments": "not valid XML",
    "mcap messages": "too many messages",
    "mcap zeros": "implausible size",
}
"""Pattern of the outcome, where more is known than that it is named."""


def check(names, call_all):
    outcomes = call_all(small_bombs.read_bomb, [(name,) for name in names], cpu=CPU_SECONDS + MAKING)
    for name, outcome in zip(names, outcomes, strict=True):
        assert outcome == "ok" or outcome.startswith("refused: "), (name, outcome)
        if outcome != "ok":
            assert "small." in outcome, f"{name}: the file is not named: {outcome}"
        assert re.search(EXPECTED.get(name, ""), outcome), (name, outcome)


def test_small_files_are_read_within_limits(call_all):
    check([name for name in BOMBS if name not in LONG], call_all)


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(LONG))
def test_more_small_files_are_read_within_limits(call_all, name):
    check([name], call_all)

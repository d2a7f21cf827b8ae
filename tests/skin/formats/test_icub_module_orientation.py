"""Turned and mirrored modules are found from their neighbours; nothing is proposed where those are inconclusive."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats.icub.layout import IcubLayout, LayoutModule, apply_layout, read_icub_layout
from tactile_maps.skin.formats.icub.module_orientation import NEIGHBOUR_DISTANCE, propose_orientations, reoriented
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_taxels import strip
from tests.support.real_icub import LAYOUTS, POSITIONS, needs_files


def misdrawn(layout, states):
    return replace(layout, modules=tuple(reoriented(m, states.get(m.number, 0)) for m in layout.modules))


def torn_and_cost(taxels, layout):
    """Counted by brute force over all pairs."""
    joined = apply_layout(taxels, layout)
    true = np.linalg.norm(joined.positions[:, None] - joined.positions, axis=2)
    flat = np.linalg.norm(joined.points[:, None] - joined.points, axis=2)
    i, j = np.nonzero(np.triu((true < NEIGHBOUR_DISTANCE) & (joined.modules[:, None] != joined.modules), 1))
    ratio = flat[i, j] / true[i, j]
    return int((ratio > 2).sum()), float(np.abs(np.log(ratio)).sum())


def test_orientation_state_moves_pads_but_not_the_triangle():
    module = LayoutModule(3, 0.1, 0.2, 0.4)
    touch = [k for k in range(12) if k not in (6, 10)]
    for state in range(6):
        points = reoriented(module, state).points
        np.testing.assert_allclose(points[3], [0.1, 0.2], atol=1e-12)
        apart = np.linalg.norm(points[touch][:, None] - module.points[touch], axis=2)
        assert apart.min(axis=0).max() < 2e-5
        assert (np.linalg.norm(points - module.points, axis=1).max() > 0.01) == (state > 0)


def test_correct_map_is_unchanged():
    taxels, layout = strip()
    candidates = propose_orientations(taxels, layout)
    assert (candidates.torn_before, candidates.torn_after, candidates.states.any()) == (0, 0, False)
    assert candidates.contact_count == 8
    assert candidates.pairs > 8
    assert candidates.finding("strip") is None
    assert candidates.apply(layout) == layout


@pytest.mark.parametrize("states", [{5: 2}, {4: 3}, {2: 1, 6: 4, 9: 2}, dict.fromkeys(range(2, 9), 3)])
def test_rotated_and_mirrored_modules_are_corrected(states):
    taxels, true = strip()
    wrong = misdrawn(true, states)
    before = torn_and_cost(taxels, wrong)[0]
    assert before > 0
    candidates = propose_orientations(taxels, wrong)
    assert (candidates.torn_before, candidates.torn_after) == (before, 0)
    changed = {int(m) for m, s in zip(candidates.modules, candidates.states, strict=True) if s}
    assert changed == set(states)
    assert set(candidates.turned) | set(candidates.mirrored) == changed
    right = apply_layout(taxels, candidates.apply(wrong))
    np.testing.assert_allclose(right.points, apply_layout(taxels, true).points, atol=3e-5)
    assert candidates.finding("strip").count == len(states)


@pytest.mark.long
def test_proposal_has_the_smallest_cost_of_all_states():
    taxels, true = strip(4)
    wrong = misdrawn(true, {2: 4, 3: 1, 5: 5})
    candidates = propose_orientations(taxels, wrong)
    best = min(
        torn_and_cost(taxels, misdrawn(wrong, dict(zip(range(2, 6), states, strict=True))))[1]
        for states in product(range(6), repeat=4)
    )
    assert torn_and_cost(taxels, candidates.apply(wrong))[1] == pytest.approx(best, abs=0.2)


def test_orientation_of_a_module_without_contact_is_unchanged():
    taxels, true = strip()
    modules = tuple(m for m in true.modules if m.number != 9)
    lonely = misdrawn(replace(true, modules=modules), {3: 2, 10: 4})
    candidates = propose_orientations(taxels, lonely)
    alone = candidates.modules == 10
    assert candidates.contacts[alone] == 0
    assert candidates.states[alone] == 0
    assert (candidates.turned, candidates.mirrored) == ({3: 120}, {})


def test_changes_without_evidence_are_not_proposed():
    taxels, true = strip()
    gappy = replace(true, modules=tuple(m for m in true.modules if m.number != 5))
    random = np.random.default_rng(1)
    for _ in range(6):
        noise = random.normal(scale=8e-4, size=taxels.positions.shape)
        rough = TaxelSet("strip", "arm", taxels.numbers, taxels.positions + noise)
        candidates = propose_orientations(rough, misdrawn(gappy, {3: 2}))
        assert (candidates.turned, candidates.mirrored) == ({3: 120}, {})


def test_orientation_of_two_isolated_modules_is_ambiguous():
    taxels, true = strip()
    modules = tuple(m for m in true.modules if m.number != 8)
    candidates = propose_orientations(taxels, misdrawn(replace(true, modules=modules), {3: 2}))
    assert (candidates.turned, candidates.mirrored) == ({3: 120}, {})


@pytest.mark.parametrize("state", range(6))
@pytest.mark.parametrize("aside", [-3e-4, 3e-4])
def test_contact_at_one_corner_does_not_determine_the_orientation(state, aside):
    taxels, layout = strip(4, radius=9.0)
    tip = max(layout.modules, key=lambda m: m.points[9, 1])
    x, y = tip.points[9]
    opposite = reoriented(LayoutModule(40, x, y + 0.0175, np.pi), state)
    whole = replace(layout, modules=(*layout.modules, opposite))
    touch = np.delete(np.arange(12), [6, 10])
    added = opposite.points[touch] + [aside, 0]  # so that a mirror image may fit better by a hair
    height = np.full(len(added), taxels.positions[:, 1].mean())
    positions = np.concatenate([taxels.positions, np.stack([added[:, 0], height, added[:, 1]], axis=1)])
    more = TaxelSet("strip", "arm", np.concatenate([taxels.numbers, 480 + touch]), positions)
    candidates = propose_orientations(more, misdrawn(whole, {3: 2}))
    assert candidates.contacts[-1] == 1
    assert (candidates.turned, candidates.mirrored) == ({3: 120}, {})


def test_layout_of_another_patch_is_rejected():
    taxels, _ = strip()
    with pytest.raises(SkinError, match="none of these taxels"):
        propose_orientations(taxels, IcubLayout("other", (LayoutModule(77, 0, 0, 0),)))


@needs_files
@pytest.mark.parametrize(
    ("positions", "layout", "torn", "pairs", "contacts", "turned", "mirrored"),
    [
        # The arm's modules touch mostly at corners, which cannot distinguish a turn from a mirror image.
        ("left_arm", "left_arm_V2_7", 1, 44, 15, {38: 240}, {}),
        ("left_forearm_V2", "left_forearm_V2", 55, 69, 25, {}, dict.fromkeys(range(16), 0)),
        ("torso", "torso", 7, 171, 50, {52: 120}, {}),
    ],
)
def test_real_patches_give_the_known_results(positions, layout, torn, pairs, contacts, turned, mirrored):
    taxels = read_icub_positions(POSITIONS / f"{positions}.txt")
    drawn = read_icub_layout(LAYOUTS / f"{layout}.ini")
    candidates = propose_orientations(taxels, drawn)
    assert (candidates.torn_before, candidates.pairs, candidates.contact_count) == (torn, pairs, contacts)
    assert candidates.torn_after == 0
    assert (candidates.turned, candidates.mirrored) == (turned, mirrored)
    assert torn_and_cost(taxels, candidates.apply(drawn))[0] == 0

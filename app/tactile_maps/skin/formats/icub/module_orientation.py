"""Modules of a hand-drawn map that seem rotated or mirrored, with proposals for their correction.

A stroke over the border of two modules must not jump on the map. If taxels of two modules are adjacent on the body but
far apart on the map, one of the modules is drawn in another of the six orientations of a triangle (three rotations,
each also mirrored). The files do not show which of them is wrong, so that nothing is changed here: orientations are
proposed with their evidence, and the user decides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.skin.formats.icub.layout import IcubLayout, LayoutModule
from tactile_maps.skin.formats.icub.positions import ROWS_PER_MODULE
from tactile_maps.skin.model.taxel_set import TaxelSet

NEIGHBOUR_DISTANCE = 0.008
"""Largest distance of adjacent taxels on the body [m]; in a module it is 6.5 mm."""
TORN_RATIO = 2.0
"""Distance of adjacent taxels on the map over that on the body, above which the pair is torn."""
RESTARTS = 300
_STATES = 6
_CHANGE_COST = 0.05  # cost of any change, so that changes without evidence are not proposed
_MAX_ROUNDS = 100


@dataclass(frozen=True, eq=False)
class OrientationProposal(ArrayFields):
    """Proposed orientations of the modules of a layout, which ``apply`` changes.

    Attributes:
        modules: (m,) numbers of the triangular modules, in the order of the layout.
        states: (m,) 0 as drawn; 1 and 2 rotated by 120 and 240 degrees; 3, 4 and 5 the same, but mirrored first.
        torn_before: Number of torn pairs of neighbours in different modules of the layout.
        torn_after: Number of torn pairs with the proposal.
        pairs: Number of pairs of neighbours in different modules.
        contacts: (m,) number of modules that each one touches; a module without contacts stays as drawn.
    """

    modules: IntArray
    states: IntArray
    torn_before: int
    torn_after: int
    pairs: int
    contacts: IntArray

    @property
    def turned(self) -> dict[int, int]:
        """Angles [degrees] by module number, of modules to be rotated but not mirrored."""
        return {int(m): 120 * int(s) for m, s in zip(self.modules, self.states, strict=True) if 0 < s < 3}

    @property
    def mirrored(self) -> dict[int, int]:
        """Angles [degrees] by module number, of modules to be mirrored and then rotated."""
        return {int(m): 120 * int(s - 3) for m, s in zip(self.modules, self.states, strict=True) if s >= 3}

    @property
    def contact_count(self) -> int:
        """Number of pairs of modules that touch, which determine the solution."""
        return int(self.contacts.sum()) // 2

    def finding(self, where: str) -> Finding | None:
        """Return a finding with the proposal for the file ``where``; None if nothing is torn."""
        if not self.torn_before:
            return None
        action = (
            f"{self.torn_before} of {self.pairs} neighbours across modules are torn, {self.torn_after} would be with "
            f"{len(self.mirrored)} modules mirrored and {len(self.turned)} rotated, from {self.contact_count} contacts"
        )
        return Finding("modules-misplaced", where, action, len(self.mirrored) + len(self.turned))

    def apply(self, layout: IcubLayout) -> IcubLayout:
        """Return ``layout`` with the proposed states."""
        states = dict(zip(self.modules.tolist(), self.states.tolist(), strict=True))
        return replace(layout, modules=tuple(reoriented(m, states.get(m.number, 0)) for m in layout.modules))


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Pairs of neighbours on the body in two modules: modules (p, 2), pads (p, 2), and their distances (p,) [m]."""

    modules: IntArray
    pads: IntArray
    lengths: FloatArray


def reoriented(module: LayoutModule, state: int) -> LayoutModule:
    """Return ``module`` in one of its six states, at the same position."""
    if not state:
        return module
    turn = 2 * np.pi / 3 * (state % 3)
    return replace(module, angle=module.angle + turn, mirrored=module.mirrored ^ (state >= 3))


def propose_orientations(taxels: TaxelSet, layout: IcubLayout, *, seed: int = 0) -> OrientationProposal:
    """Return the states of the modules of ``layout`` for which neighbours on the body are neighbours on the map.

    Minimises the sum of ``|log(map length / true length)|`` over all pairs of neighbours in two modules, by coordinate
    descent from the layout, from all modules in the same state, and from ``RESTARTS`` random starts. Only triangular
    modules are considered; without any, nothing is proposed.

    Args:
        taxels: Taxels with the numbers of the robot; only their positions are used.
        layout: Layout of the same patch.
        seed: Seed of the random starts.

    Raises:
        SkinError: The layout has none of the taxels.

    Cost: about 0.1 s for 64 modules; nothing if no pair is torn.
    """
    modules = [m for m in layout.modules if m.kind.triangular and layout.starts[m.number] == ROWS_PER_MODULE * m.number]
    if not modules:
        nothing = np.zeros(0, dtype=np.int64)
        return OrientationProposal(nothing, nothing, 0, 0, 0, nothing)
    numbers = np.array([module.number for module in modules])
    pairs = _near_pairs(taxels, numbers)
    drawn = np.stack([[reoriented(module, s).points for s in range(_STATES)] for module in modules])
    ratios = _ratios(pairs, drawn)
    as_drawn = np.zeros(len(numbers), dtype=np.int64)
    torn = _count_torn(pairs, ratios, as_drawn)
    keys, contact = np.unique(pairs.modules[:, 0] * len(numbers) + pairs.modules[:, 1], return_inverse=True)
    touching = np.stack(np.divmod(keys, len(numbers)), axis=1)
    contacts = np.bincount(touching.ravel(), minlength=len(numbers))
    if not torn:
        return OrientationProposal(numbers, as_drawn, 0, 0, len(pairs.lengths), contacts)
    costs = np.zeros((len(keys), _STATES, _STATES))
    np.add.at(costs, contact.ravel(), np.abs(np.log(ratios)))
    ends, totals = _coordinate_descent(costs, touching, _initial_states(len(numbers), seed))
    best = ends[totals.argmin()]
    after = _count_torn(pairs, ratios, best)
    return OrientationProposal(numbers, best, torn, after, len(pairs.lengths), contacts)


def _near_pairs(taxels: TaxelSet, numbers: IntArray) -> _Pairs:
    order = np.argsort(numbers)
    place = order[np.minimum(np.searchsorted(numbers[order], taxels.stated_ids // ROWS_PER_MODULE), len(order) - 1)]
    shown = numbers[place] == taxels.stated_ids // ROWS_PER_MODULE
    if not shown.any():
        raise SkinError("the layout shows none of these taxels", place=taxels.name, remedy="Choose that of the patch")
    positions = taxels.positions[shown]
    module = place[shown]
    pad = taxels.stated_ids[shown] % ROWS_PER_MODULE
    near = cKDTree(positions).query_pairs(NEIGHBOUR_DISTANCE, output_type="ndarray").reshape(-1, 2)
    near = near[module[near[:, 0]] != module[near[:, 1]]]
    near = np.where((module[near[:, 0]] > module[near[:, 1]])[:, None], near[:, ::-1], near)
    lengths = np.linalg.norm(positions[near[:, 0]] - positions[near[:, 1]], axis=1)
    near = near[lengths > 0]
    lengths = lengths[lengths > 0]
    return _Pairs(module[near], pad[near], lengths)


def _ratios(pairs: _Pairs, drawn: FloatArray) -> FloatArray:
    """Return (p, 6, 6) lengths on the map over lengths on the body, above zero, by the states of the two modules."""
    first, second = (drawn[pairs.modules[:, k], :, pairs.pads[:, k]] for k in range(2))
    apart = np.linalg.norm(first[:, :, None] - second[:, None, :], axis=3)
    return np.maximum(apart / pairs.lengths[:, None, None], 1e-6)


def _count_torn(pairs: _Pairs, ratios: FloatArray, states: IntArray) -> int:
    first, second = states[pairs.modules].T
    return int((ratios[np.arange(len(ratios)), first, second] > TORN_RATIO).sum())


def _initial_states(count: int, seed: int) -> IntArray:
    """Return (r, count) initial states: all modules in the same state, and random ones."""
    alike = np.repeat(np.arange(_STATES)[:, None], count, axis=1)
    return np.concatenate([alike, np.random.default_rng(seed).integers(_STATES, size=(RESTARTS, count))])


def _coordinate_descent(costs: FloatArray, touching: IntArray, states: IntArray) -> tuple[IntArray, FloatArray]:
    """Return states (r, m) that no change of a single module improves, and their total costs (r,).

    Args:
        costs: (c, 6, 6) cost of each contact by the states of its two modules.
        touching: (c, 2) the two modules.
        states: (r, m) initial states.
    """
    states = states.copy()
    change = _CHANGE_COST * (np.arange(_STATES) > 0)
    for _ in range(_MAX_ROUNDS):
        before = states.copy()
        for module in range(states.shape[1]):
            states[:, module] = (change + _scores(costs, touching, states, module)).argmin(axis=1)
        if (states == before).all():
            break
    first = states[:, touching[:, 0]]
    second = states[:, touching[:, 1]]
    return states, costs[np.arange(len(costs)), first, second].sum(axis=1) + change[states].sum(axis=1)


def _scores(costs: FloatArray, touching: IntArray, states: IntArray, module: int) -> FloatArray:
    """Return (r, 6) cost of the contacts of ``module`` in each of its states, with the others in ``states`` (r, m)."""
    as_first, as_second = (np.flatnonzero(touching[:, k] == module) for k in range(2))
    others = states[:, touching[as_first, 1]], states[:, touching[as_second, 0]]
    return costs[as_first, :, others[0]].sum(axis=1) + costs[as_second, others[1], :].sum(axis=1)

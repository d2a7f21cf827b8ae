"""A restless hand on a map and its pins: whatever it edits, undoes, saves and loads, the map stays valid and nothing is
lost.
"""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import (
    EDGES,
    align,
    mirror,
    move,
    repack,
    rotate,
    scale,
    snap_move,
    true_size,
)
from tactile_maps.editing.document import MapDocument, rename_patch, reorder_patch, show_patches
from tactile_maps.editing.document_file import DocumentFile, document_to_bytes, load_document
from tactile_maps.editing.history import History
from tactile_maps.editing.pins import (
    add_pin,
    begin_pin_drag,
    chart_place,
    finish_pin_drag,
    nudge_pins,
    pin_places,
    remove_pins,
    with_dragged_patch,
)
from tactile_maps.editing.reflatten import (
    StaleEdit,
    apply_result,
    chart_fingerprint,
    reflatten,
    set_lengths,
    set_method,
)
from tactile_maps.editing.seams import draw_seam, erase_seams, paint_interest, propose_seam
from tactile_maps.flattening.bijectivity import crossings, flipped
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.methods import METHODS
from tactile_maps.flattening.pinned_patch import PinnedPatch
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.quality import overlaps
from tests.support.examples import examples
from tests.support.surfaces import cap, frustum, sheet, skin_of

COUNT = 3
patches = st.integers(0, COUNT - 1)
several = st.sets(patches)
steps = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
angles = st.floats(-7, 7)


@cache
def first_map():
    """A tube, a sheet and a cone, each with a few taxels."""
    return build_map(skin_of(frustum(around=12, along=5), sheet(6, 5), frustum(top=0.02, around=10, along=4), taxels=8))


class RandomEdits(RuleBasedStateMachine):
    """Random edits of a small map, compared with a plain list of the documents that undo must restore."""

    @initialize()
    def open(self):
        self.first = MapDocument.of(first_map())
        self.history = History(self.first)
        self.model = [self.first]
        self.at = 0
        self.folder = tempfile.TemporaryDirectory()
        self.file = DocumentFile(None, None)
        self.file.save_as(self.first, Path(self.folder.name) / "map.npz")
        self.on_disk = self.first
        self.pending = None
        self.valid = {}

    def teardown(self):
        if hasattr(self, "folder"):
            assert self.history.go(0) is self.first
            assert document_to_bytes(self.history.present) == document_to_bytes(MapDocument.of(first_map()))
            self.folder.cleanup()

    @property
    def present(self):
        return self.history.present

    @property
    def pinned(self):
        """(patch, pin) of every pin."""
        return [(k, pin) for k, patch in enumerate(self.present.patches) for pin in range(len(patch.pins))]

    def _do(self, name, edit):
        """An edit as a window makes it; one that is refused changes nothing."""
        before = self.present
        try:
            new = edit(before)
        except MapError:
            assert self.present is before
            return
        self.history.do(name, new)
        if new is not before:
            self.model = [*self.model[: self.at + 1], new]
            self.at = self.at + 1

    def _compute(self, ask):
        self._do("Reflatten", lambda document: apply_result(document, reflatten(ask(document))))

    @rule(numbers=several, by=steps, reach=st.floats(0, 0.05))
    def moves(self, numbers, by, reach):
        self._do("Move", lambda d: move(d, numbers, snap_move(d, numbers, by, reach=reach).by))

    @rule(numbers=several, angle=angles)
    def turns(self, numbers, angle):
        self._do("Rotate", lambda d: rotate(d, numbers, angle))

    @rule(numbers=several, factor=st.one_of(st.none(), st.floats(0.3, 3)))
    def scales(self, numbers, factor):
        self._do("Scale", lambda d: mirror(d, numbers) if factor is None else scale(d, numbers, factor))

    @rule(numbers=several, edge=st.sampled_from([*EDGES, None]))
    def lines_up(self, numbers, edge):
        self._do("Align", lambda d: true_size(d, numbers) if edge is None else align(d, numbers, edge))

    @rule(numbers=st.one_of(st.none(), several))
    def packs(self, numbers):
        self._do("Pack", lambda d: repack(d, numbers))
        if numbers is None:
            assert overlaps(self.present.map) == 0

    @rule(number=patches, name=st.text(max_size=5), visible=st.booleans(), to=st.integers(-1, COUNT))
    def tidies_the_tree(self, number, name, visible, to):
        before = self.present.map
        for edit in (lambda d: rename_patch(d, number, name), lambda d: show_patches(d, [number], visible=visible)):
            self._do("Tree", edit)
        self._do("Order", lambda d: reorder_patch(d, number, to))
        assert self.present.map is before

    @rule(numbers=several, by=st.lists(steps, max_size=5), cancelled=st.booleans())
    def drags(self, numbers, by, cancelled):
        start = self.present
        self.history.begin("Drag")
        for step in by:
            self.history.change(move(start, numbers, step))
        (self.history.cancel if cancelled else self.history.end)()
        if cancelled:
            assert self.present is start
        elif self.present is not start:
            self.model = [*self.model[: self.at + 1], self.present]
            self.at = self.at + 1

    @rule(numbers=several, method=st.sampled_from(sorted(METHODS)))
    def chooses_a_method(self, numbers, method):
        self._compute(lambda d: set_method(d, numbers, method))

    @rule(numbers=several, lengths=st.floats(-0.1, 1.1))
    def slides(self, numbers, lengths):
        self._compute(lambda d: set_lengths(d, numbers, lengths))

    @rule(number=patches, through=st.lists(st.integers(-1, 45), max_size=3))
    def draws_a_seam(self, number, through):
        self._compute(lambda d: draw_seam(d, number, through))

    @rule(number=patches, part=st.floats(0, 1))
    def erases_seams(self, number, part):
        seams = self.present.charts[number].seams
        self._compute(lambda d: erase_seams(d, number, seams[: round(part * len(seams))]))

    @rule(number=patches)
    def takes_a_proposal(self, number):
        self._compute(lambda d: propose_seam(d, number))

    @rule(number=patches, vertices=st.lists(st.integers(-1, 45), max_size=8), importance=st.sampled_from([0.0, 100.0]))
    def paints(self, number, vertices, importance):
        self._compute(lambda d: paint_interest(d, number, vertices, importance=importance))

    @rule(number=patches, face=st.integers(-1, 60), corner=st.integers(0, 2))
    def pins(self, number, face, corner):
        weights = np.roll([0.6, 0.3, 0.1], corner)
        self._do("Pin", lambda d: add_pin(d, SurfacePoint(number, face, tuple(weights))))

    @precondition(lambda self: self.pinned)
    @rule(which=st.integers(0, 30), by=st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)))
    def moves_a_pin(self, which, by):
        number, pin = self.pinned[which % len(self.pinned)]
        self._compute(lambda d: nudge_pins(d, {number: [pin]}, by))

    @precondition(lambda self: self.pinned)
    @rule(which=st.integers(0, 30), frames=st.lists(steps, min_size=1, max_size=4))
    def drags_a_pin(self, which, frames):
        (number, pin), start = self.pinned[which % len(self.pinned)], self.present
        self.history.begin("Drag a pin")
        gripped = begin_pin_drag(start, number)
        place = pin_places(start, number)[pin]
        for by in frames:
            gripped.move(pin, chart_place(start, number, place + 0.1 * np.array(by)))
            gripped.frame()
            self.history.change(with_dragged_patch(start, number, gripped))
            chart = self.present.charts[number]
            assert not flipped(chart.plane, chart.faces).any()
        try:
            exact = apply_result(self.present, reflatten(finish_pin_drag(self.present, number)))
        except MapError:
            self.history.cancel()
            assert self.present is start
            return
        self.history.end()
        self.history.refine(exact)
        self.model = [*self.model[: self.at + 1], exact]
        self.at = self.at + 1

    @precondition(lambda self: self.pinned)
    @rule(which=st.integers(0, 30))
    def takes_a_pin_out(self, which):
        number, pin = self.pinned[which % len(self.pinned)]
        self._compute(lambda d: remove_pins(d, number, [pin]))

    @precondition(lambda self: self.pending is None)
    @rule(number=patches, method=st.sampled_from(["tutte", "lscm"]))
    def asks_the_worker(self, number, method):
        self.pending = reflatten(set_method(self.present, [number], method))

    @precondition(lambda self: self.pending is not None)
    @rule()
    def hears_from_the_worker(self):
        late = any(chart_fingerprint(self.present, job.number) != job.stamp for job in self.pending.request.jobs)
        try:
            new = apply_result(self.present, self.pending)
        except StaleEdit:
            assert late
        else:
            assert not late
            self._do("Worker", lambda _: new)
        self.pending = None

    @rule()
    def undoes(self):
        self.at = max(self.at - 1, 0)
        assert self.history.undo() is self.model[self.at]

    @rule()
    def redoes(self):
        self.at = min(self.at + 1, len(self.model) - 1)
        assert self.history.redo() is self.model[self.at]

    @rule(part=st.floats(0, 1))
    def goes_back_in_the_list(self, part):
        self.at = round(part * (len(self.model) - 1))
        assert self.history.go(self.at) is self.model[self.at]

    @rule()
    def saves(self):
        self.file.save_as(self.present, self.file.path)
        self.on_disk = self.present
        assert not self.file.unsaved(self.present)

    @rule()
    def saves_itself(self):
        assert self.file.autosave(self.present) <= (self.present is not self.on_disk)

    @rule()
    def loads(self):
        back = load_document(self.file.path)
        assert document_to_bytes(back) == document_to_bytes(self.on_disk)
        assert [chart_fingerprint(back, k) for k in range(COUNT)] == [
            chart_fingerprint(self.on_disk, k) for k in range(COUNT)
        ]

    @invariant()
    def the_map_is_valid(self):
        if not hasattr(self, "history"):
            return
        assert self.present.skin is self.first.skin
        for chart, patch in zip(self.present.charts, self.present.skin.patches, strict=True):
            if id(chart) not in self.valid:
                assert not flipped(chart.plane, chart.faces).any()
                assert crossings(chart.plane[chart.border]) == 0
                np.testing.assert_array_equal(chart.vertex_of[chart.faces], patch.surface.faces)
                self.valid[id(chart)] = chart

    @invariant()
    def undo_knows_where_it_is(self):
        if hasattr(self, "history"):
            assert self.present is self.model[self.at]
            assert len(self.history.names) == len(self.model)
            assert self.file.unsaved(self.present) == (self.present is not self.on_disk)


RandomEdits.TestCase.settings = examples(20, stateful_step_count=40)
test_random_edits = RandomEdits.TestCase


SURFACES = (
    cap(1.2, rings=8, radius=0.05),
    frustum(around=24, along=12),
    sheet(20, 14, shape=lambda x, y: 0.01 * np.sin(70 * x) * np.cos(60 * y)),
)
CHARTS = tuple(flatten(surface) for surface in SURFACES)

shares = st.floats(0, 1)
weights = st.tuples(shares, shares, shares).filter(lambda w: sum(w) > 0.1)
places = st.tuples(st.floats(-1, 2), st.floats(-1, 2))
acts = st.one_of(
    st.tuples(st.just("add"), st.integers(0, 10**6), weights, places),
    st.tuples(st.just("move"), st.integers(0, 20), places),
    st.tuples(st.just("wait"), st.integers(1, 4)),
)


def on_map(chart, share):
    """A place by shares of the map's box; outside from 0 to 1 is outside the map."""
    low = chart.plane.min(axis=0)
    high = chart.plane.max(axis=0)
    return low + (high - low) * share


def act(patch, chart, what, *how):
    """Run an edit, which may be rejected by name."""
    numbers = list(patch.pins)
    try:
        if what == "add":
            face, corner_weights, place = how
            unit = np.array(corner_weights) / sum(corner_weights)
            patch.add(SurfacePoint(0, face % len(chart.faces), tuple(unit.tolist())), on_map(chart, place))
        elif what == "move" and numbers:
            patch.move(numbers[how[0] % len(numbers)], on_map(chart, how[1]))
    except MapError as refused:
        return str(refused)
    return ""


@pytest.mark.long
@examples(150, derandomize=True)
@given(st.integers(0, len(SURFACES) - 1), st.booleans(), st.sampled_from([0.0, 0.6, 1.0]), st.lists(acts, max_size=14))
def test_random_drags_cause_no_flipped_triangle(which, by_proxy, lengths, done):
    surface = SURFACES[which]
    chart = CHARTS[which]
    patch = PinnedPatch(surface, chart, lengths=lengths, whole=100 if by_proxy else 10**6)
    for what, *how in done:
        act(patch, chart, what, *how)
        for frame in range(how[0] if what == "wait" else 1):
            before = patch.energy
            plane = patch.frame()
            assert np.isfinite(plane).all()
            assert not flipped(plane, chart.faces).any()
            assert patch.energy <= before, frame
            assert np.isfinite(patch.lags).all()


@examples(12, derandomize=True)
@given(st.integers(0, len(SURFACES) - 1), st.lists(acts, min_size=2, max_size=8))
def test_random_drags_settle_one_to_one_or_leave_the_map_unchanged(which, done):
    surface = SURFACES[which]
    chart = CHARTS[which]
    patch = PinnedPatch(surface, chart)
    for what, *how in done:
        act(patch, chart, what, *how)
        patch.frame()
    before = patch.plane
    try:
        settled = patch.converge()
    except MapError:
        np.testing.assert_array_equal(patch.plane, before)
        return
    assert not flipped(settled.plane, settled.faces).any()
    assert crossings(settled.plane[settled.border]) == 0


def pulled(surface, chart, faces, moves):
    """The settled map after pins in ``faces`` made ``moves``."""
    patch = PinnedPatch(surface, chart)
    for face, by in zip(faces, moves, strict=True):
        number = patch.add(SurfacePoint(0, int(face), (0.2, 0.3, 0.5)))
        patch.move(number, np.array(patch.pins[number].place) + by)
    for _ in range(3):
        patch.frame()
    return patch, patch.converge()


@pytest.mark.parametrize("which", range(len(SURFACES)))
def test_order_of_faces_and_pins_does_not_matter(which):
    surface = SURFACES[which]
    chart = CHARTS[which]
    faces = np.array([3, 50, 150])
    moves = np.array([[0.008, 0.0], [0.0, 0.0], [0.0, 0.004]])
    _, straight = pulled(surface, chart, faces, moves)
    order = np.random.default_rng(which).permutation(len(surface.faces))
    mixed = Mesh(surface.vertices, surface.faces[order])
    other = Chart(chart.faces[order], chart.plane, chart.vertex_of, chart.seams, chart.method)
    _, shuffled = pulled(mixed, other, np.argsort(order)[faces[::-1]], moves[::-1])
    np.testing.assert_allclose(shuffled.plane, straight.plane, atol=2e-3 * np.sqrt(surface.area))
    assert shuffled.energies[-1] == pytest.approx(straight.energies[-1], rel=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("which", range(len(SURFACES)))
@examples(5, derandomize=True)
@given(turn=st.floats(-3, 3), shift=st.tuples(st.floats(-2, 2), st.floats(-2, 2)), size=st.sampled_from([0.01, 1, 100]))
def test_drag_is_invariant_to_rotation_translation_and_scale(which, turn, shift, size):
    surface = SURFACES[which]
    chart = CHARTS[which]
    faces = np.array([3, 50, 150])
    moves = np.array([[0.008, 0.0], [0.0, 0.0], [0.0, 0.004]])
    straight, settled = pulled(surface, chart, faces, moves)
    rotation = size * np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    larger = Mesh(size * surface.vertices, surface.faces)
    there = Chart(chart.faces, chart.plane @ rotation + shift, chart.vertex_of, chart.seams, chart.method)
    other, moved = pulled(larger, there, faces, moves @ rotation)
    unit = size * np.sqrt(surface.area)
    np.testing.assert_allclose(moved.plane, settled.plane @ rotation + shift, atol=2e-3 * unit)
    assert other.energy == pytest.approx(straight.energy, rel=1e-3)

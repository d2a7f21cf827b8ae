"""A restless hand on a map: whatever it edits, undoes, saves and loads, the map stays valid and nothing is lost."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from app.editing.arrange import EDGES, align, mirror, move, repack, rotate, scale, true_size
from app.editing.autosave import DocumentFile
from app.editing.document import MapDocument
from app.editing.document_file import document_to_bytes, load_document
from app.editing.history import History
from app.editing.patches import rename, reorder, show
from app.editing.pins import add_pin, chart_place, grip, hold, move_pin, pin_places, remove_pins, settle
from app.editing.reflatten import StaleEdit, apply, reflatten, set_lengths, set_method, stamp
from app.editing.seams import draw_seam, erase_seams, paint_interest, propose_seam
from app.editing.snap import snap_angle, snap_move
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.bijective import crossings, flipped
from app.maps.build import build_map
from app.maps.methods.table import METHODS
from app.maps.quality import overlaps
from tests.numerics.map_surfaces import frustum, sheet, skin_of

COUNT = 3
patches = st.integers(0, COUNT - 1)
several = st.sets(patches)
steps = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
angles = st.floats(-7, 7)


@cache
def first_map():
    """A tube, a sheet and a cone, each with a few taxels."""
    return build_map(skin_of(frustum(around=12, along=5), sheet(6, 5), frustum(top=0.02, around=10, along=4), taxels=8))


class RestlessHand(RuleBasedStateMachine):
    """Edits of a small map in any order, beside a plain list of the documents that undo must come back to."""

    @initialize()
    def open(self):
        self.first = MapDocument.of(first_map())
        self.history, self.model, self.at = History(self.first), [self.first], 0
        self.folder = tempfile.TemporaryDirectory()
        self.file = DocumentFile(None, None)
        self.file.save_as(self.first, Path(self.folder.name) / "map.npz")
        self.on_disk, self.pending, self.valid = self.first, None, {}

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
            self.model, self.at = [*self.model[: self.at + 1], new], self.at + 1

    def _compute(self, ask):
        self._do("Reflatten", lambda document: apply(document, reflatten(ask(document))))

    @rule(numbers=several, by=steps, reach=st.floats(0, 0.05))
    def moves(self, numbers, by, reach):
        self._do("Move", lambda d: move(d, numbers, snap_move(d, numbers, by, reach=reach).by))

    @rule(numbers=several, angle=angles)
    def turns(self, numbers, angle):
        self._do("Turn", lambda d: rotate(d, numbers, angle))

    @rule(number=patches, angle=angles)
    def turns_and_snaps(self, number, angle):
        self._do("Turn", lambda d: rotate(d, [number], snap_angle(d, number, angle)))

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
        for edit in (lambda d: rename(d, number, name), lambda d: show(d, [number], visible=visible)):
            self._do("Tree", edit)
        self._do("Order", lambda d: reorder(d, number, to))
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
            self.model, self.at = [*self.model[: self.at + 1], self.present], self.at + 1

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
        goal = pin_places(self.present, number)[pin] + by
        self._compute(lambda d: move_pin(d, number, pin, goal))

    @precondition(lambda self: self.pinned)
    @rule(which=st.integers(0, 30), frames=st.lists(steps, min_size=1, max_size=4))
    def drags_a_pin(self, which, frames):
        (number, pin), start = self.pinned[which % len(self.pinned)], self.present
        self.history.begin("Drag a pin")
        gripped, place = grip(start, number), pin_places(start, number)[pin]
        for by in frames:
            gripped.move(pin, chart_place(start, number, place + 0.1 * np.array(by)))
            gripped.frame()
            self.history.change(hold(start, number, gripped))
            chart = self.present.charts[number]
            assert not flipped(chart.plane, chart.faces).any()
        try:
            exact = apply(self.present, reflatten(settle(self.present, number)))
        except MapError:
            self.history.cancel()
            assert self.present is start
            return
        self.history.end()
        self.history.refine(exact)
        self.model, self.at = [*self.model[: self.at + 1], exact], self.at + 1

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
        late = any(stamp(self.present, job.number) != job.stamp for job in self.pending.request.jobs)
        try:
            new = apply(self.present, self.pending)
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
        self.file.save(self.present)
        self.on_disk = self.present
        assert not self.file.unsaved(self.present)

    @rule()
    def saves_itself(self):
        assert self.file.autosave(self.present) <= (self.present is not self.on_disk)

    @rule()
    def loads(self):
        back = load_document(self.file.path)
        assert document_to_bytes(back) == document_to_bytes(self.on_disk)
        assert [stamp(back, k) for k in range(COUNT)] == [stamp(self.on_disk, k) for k in range(COUNT)]

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


RestlessHand.TestCase.settings = settings(
    max_examples=20, stateful_step_count=40, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
test_a_restless_hand = RestlessHand.TestCase

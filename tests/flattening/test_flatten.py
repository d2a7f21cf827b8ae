"""A patch flattened: optimal, one-to-one, true to size, upright, and honest about what it took."""

from __future__ import annotations

from collections import Counter
from functools import cached_property

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import crossings, flipped, signed_areas
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.methods import METHODS
from tactile_maps.flattening.newton import minimise
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import hard_mesh
from tests.support.surfaces import blocks, cap, frustum, named, sheet


def _kinds(chart):
    return {finding.kind for finding in chart.findings}


@pytest.mark.sampled(4)
@pytest.mark.parametrize("method", METHODS)
def test_map_has_the_area_of_the_surface_and_starts_at_the_origin(method):
    surface = named("bumpy tube")
    chart = flatten(surface, method=method)
    assert chart.method == method
    assert signed_areas(chart.plane, chart.faces).sum() == pytest.approx(surface.area, rel=1e-9)
    np.testing.assert_allclose(chart.plane.min(axis=0), 0, atol=1e-12)


def test_long_direction_of_the_body_points_up_and_away_from_the_joint():
    along_x = frustum(0.03, 0.02, length=0.2)
    surface = Mesh(along_x.vertices[:, [2, 0, 1]] + [0.1, 0, 0], along_x.faces)
    chart = flatten(surface)
    x = surface.vertices[chart.vertex_of, 0]
    correlation = np.corrcoef(np.column_stack([x, chart.plane]).T)
    assert correlation[0, 2] > 0.98
    assert abs(correlation[0, 1]) < 0.1


def test_map_is_always_seen_from_outside():
    surface = named("cap")
    chart = flatten(surface)
    assert not flipped(chart.plane, chart.faces).any()


def test_deep_patch_gets_a_seam_with_a_finding():
    chart = flatten(named("nearly closed"), name="head")
    (note,) = chart.findings
    assert (note.kind, note.where) == ("seam-added", "head")
    assert len(chart.seams) > 0
    assert chart.energies[-1] < 4.6


def test_shallow_patch_gets_no_seam():
    chart = flatten(cap(1.2))
    assert chart.findings == ()
    assert len(chart.seams) == 0


def test_simple_method_adds_no_seam():
    chart = flatten(named("nearly closed"), method="tutte")
    assert chart.findings == ()
    assert len(chart.energies) == 1


@pytest.mark.long
@pytest.mark.parametrize("name", ["spiral", "sieve"])
def test_overlap_is_avoided_with_a_finding(name):
    chart = flatten(named(name))
    assert "overlap-avoided" in _kinds(chart)
    assert crossings(chart.plane[chart.connectivity.boundary_loops[0]]) == 0
    assert chart.energies[-1] < 4.05


def test_faces_without_area_are_reported():
    (note,) = flatten(named("thin faces")).findings
    assert (note.kind, note.count) == ("thin-face", 6)


def test_progress_is_called_every_round_and_may_cancel():
    class StopError(Exception):
        pass

    heard = []
    chart = flatten(sheet(), on_round=heard.append)
    assert [iterate.energy for iterate in heard] == list(chart.energies)

    def stop(_iterate):
        raise StopError

    with pytest.raises(StopError):
        flatten(sheet(), on_round=stop)


def test_unknown_method_names_the_known_ones():
    with pytest.raises(MapError, match=r"unknown method.*magic.*symmetric-dirichlet.*tutte"):
        flatten(sheet(), method="magic")


def test_surface_with_zero_area_raises_a_clear_error():
    with pytest.raises(MapError, match="no area"):
        flatten(Mesh(np.zeros((3, 3)), [[0, 1, 2]]))


@pytest.mark.long
def test_same_surface_gives_the_same_map_bit_for_bit():
    first = flatten(named("sieve"))
    second = flatten(named("sieve"))
    np.testing.assert_array_equal(first.plane, second.plane)


def limbs(pairs, length):
    """A closed body with ``pairs`` of limbs and a tail, each ``length`` times as long as wide: Tutte's map of it, with
    a few seams, puts the ends of the limbs on one number."""
    body = {(x, y, z) for x in range(2 * pairs + 2) for y in range(4) for z in range(2)}
    legs = {(1 + 2 * pair, y, 0) for pair in range(pairs) for n in range(length) for y in (4 + n, -1 - n)}
    return blocks(body | legs | {(-1 - n, 1, 1) for n in range(length)})


def scaffold(cells, beam):
    """A cube of ``cells``³ frames of beams: 28 handles for 2, 81 for 3."""
    side = range(cells * beam + 1)
    return blocks({(x, y, z) for x in side for y in side for z in side if sum(k % beam == 0 for k in (x, y, z)) >= 2})


def assert_one_to_one(chart):
    """No triangle is flipped, and the border does not cross itself."""
    assert not flipped(chart.plane, chart.faces).any()
    assert crossings(chart.plane[chart.connectivity.boundary_loops[0]]) == 0


@pytest.mark.long
def test_body_with_many_long_limbs_gets_a_seam_into_each():
    chart = flatten(limbs(3, 25))
    assert_one_to_one(chart)
    assert chart.energies[-1] < 4.3
    (note,) = [finding for finding in chart.findings if finding.kind == "seam-added"]
    assert note.count > 3


@pytest.mark.long
@pytest.mark.parametrize(("cells", "beam"), [pytest.param(2, 3, id="28"), pytest.param(3, 5, id="81")])
def test_body_with_many_handles_is_mapped(cells, beam):
    chart = flatten(scaffold(cells, beam))
    assert_one_to_one(chart)
    assert chart.energies[-1] < 4.3


@pytest.mark.parametrize(
    ("name", "most"), [("limbs", 4.3), pytest.param("limbs and handles", 5.0, marks=pytest.mark.long)]
)
def test_seams_are_added_until_each_limb_of_a_body_opens(name, most):
    chart = flatten(hard_mesh(name))
    assert_one_to_one(chart)
    opened = next(finding for finding in chart.findings if finding.kind == "seam-added")
    assert opened.count >= 3
    assert chart.energies[-1] < most


def test_surface_without_initial_map_is_rejected_with_the_seams_that_were_tried(monkeypatch):
    monkeypatch.setattr("tactile_maps.flattening.flatten.EASY_ENERGY", 4.0)
    monkeypatch.setattr("tactile_maps.flattening.flatten.HARDEST_ENERGY", 4.0)
    monkeypatch.setattr("tactile_maps.flattening.flatten._SEAMS_TO_OPEN", (0, 1))
    with pytest.raises(MapError, match=r"up to 1 extra seams.*Remove its thinnest limbs"):
        flatten(cap(1.0))


def test_best_map_is_tried_if_no_seam_opens_the_surface(monkeypatch):
    monkeypatch.setattr("tactile_maps.flattening.flatten.EASY_ENERGY", 4.0)
    assert_one_to_one(flatten(cap(1.0)))
    monkeypatch.setattr("tactile_maps.flattening.flatten.HARDEST_ENERGY", 4.0)
    with pytest.raises(MapError, match="no initial map"):
        flatten(cap(1.0))


@pytest.fixture
def sorted_faces(monkeypatch):
    """Count how often the edges of each set of faces were computed since."""
    counted: Counter[bytes] = Counter()
    work = Connectivity._table.func

    def counting(self):
        counted[self.faces.tobytes()] += 1
        return work(self)

    table = cached_property(counting)
    table.__set_name__(Connectivity, "_table")
    monkeypatch.setattr(Connectivity, "_table", table)
    return counted


@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", METHODS)
def test_edges_of_surface_and_cut_are_computed_once(sorted_faces, method):
    surface = frustum(0.03, 0.02, length=0.2)
    chart = flatten(surface, method=method, seams=SeamPlan(extra=0))
    assert sorted_faces == {surface.faces.tobytes(): 1, chart.faces.tobytes(): 1}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["hemisphere", "spiral"])
@pytest.mark.parametrize("short_of", ["rounds", "factorisations"])
def test_shortened_descent_is_one_to_one_and_reports_where_it_stopped(name, short_of, monkeypatch):
    surface = named(name)
    if short_of == "rounds":
        monkeypatch.setattr("tactile_maps.flattening.flatten.MOST_FACE_ROUNDS", 0)
        monkeypatch.setattr("tactile_maps.flattening.flatten._LEAST_ROUNDS", 3)
    else:
        monkeypatch.setitem(minimise.__kwdefaults__, "rounds", 1)
    short = flatten(surface)
    again = flatten(surface)
    assert "descent-stopped" in _kinds(short)
    assert not flipped(short.plane, short.faces).any()
    assert not crossings(short.plane[Connectivity(short.faces).boundary_loops[0]])
    np.testing.assert_array_equal(short.plane, again.plane)
    monkeypatch.undo()
    whole = flatten(surface)
    assert "descent-stopped" not in _kinds(whole)
    assert whole.energies[-1] < short.energies[-1]

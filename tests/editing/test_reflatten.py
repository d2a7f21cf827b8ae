"""Edits computed in a worker: the requested result is returned, and a late result is recognised."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import mirror, move, rotate
from tactile_maps.editing.document import MapDocument, rename_patch, show_patches
from tactile_maps.editing.pins import add_pin
from tactile_maps.editing.reflatten import (
    StaleEdit,
    _laid_over,
    apply_result,
    chart_fingerprint,
    kept_lengths,
    reflatten,
    request_reflatten,
    set_lengths,
    set_method,
)
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.build import flatten_patch
from tactile_maps.maps.model.layout import Placement


def test_only_the_edited_patch_is_flattened_again(document, reflattened):
    shared = [a is b for a, b in zip(reflattened.charts, document.charts, strict=True)]
    assert shared == [True, False, True]
    assert reflattened.charts[1].method == reflattened.patches[1].method == "tutte"
    assert reflattened.layout.placements[::2] == document.layout.placements[::2]


def test_chart_depends_only_on_its_edit(document, reflattened):
    back = apply_result(reflattened, reflatten(set_method(reflattened, [1], "symmetric-dirichlet")))
    np.testing.assert_array_equal(back.charts[1].plane, document.charts[1].plane)
    assert chart_fingerprint(back, 1) == chart_fingerprint(document, 1)


def test_new_chart_is_at_the_position_of_the_old_one(document):
    turned = mirror(rotate(move(document, [1], (0.3, 0.1)), [1], 0.7), [1])
    new = apply_result(turned, reflatten(set_method(turned, [1], "harmonic")))
    np.testing.assert_allclose(new.map.boxes[1].mean(axis=0), turned.map.boxes[1].mean(axis=0), atol=0.02)
    old = turned.layout.placements[1]
    assert replace(new.layout.placements[1], offset=old.offset) == old


def test_several_patches_are_one_step(document):
    asked = set_lengths(document, [0, 2], 0.25)
    assert [job.number for job in asked.jobs] == [0, 2]
    new = apply_result(document, reflatten(asked))
    assert [patch.lengths for patch in new.patches] == [0.25, 1.0, 0.25]


def test_unchanged_settings_need_no_job(document):
    asked = set_method(document, [0, 1, 2], "symmetric-dirichlet")
    assert asked.jobs == ()
    assert apply_result(document, reflatten(asked)) is document


def test_request_and_result_can_be_sent_between_processes(document):
    result = pickle.loads(pickle.dumps(reflatten(pickle.loads(pickle.dumps(set_method(document, [2], "lscm"))))))
    new = apply_result(document, result)
    assert not new.charts[2].plane.flags.writeable
    assert chart_fingerprint(new, 2) == chart_fingerprint(
        apply_result(document, reflatten(set_method(document, [2], "lscm"))), 2
    )


def test_result_for_changed_patch_is_rejected(document, reflattened):
    late = reflatten(set_lengths(document, [1], 0.5))
    with pytest.raises(StaleEdit, match="changed meanwhile"):
        apply_result(reflattened, late)
    with pytest.raises(StaleEdit):
        apply_result(MapDocument.of(apply_result(document, late).map), late)


def test_result_stays_valid_after_an_unrelated_edit(document):
    result = reflatten(set_method(document, [1], "tutte"))
    meanwhile = show_patches(
        rename_patch(move(rotate(document, [0, 1], 0.2), [1], (0.1, 0.0)), 1, "Palm"), [1], visible=False
    )
    new = apply_result(meanwhile, result)
    assert (new.patches[1].name, new.patches[1].visible) == ("Palm", False)
    assert new.layout.placements[1].angle == meanwhile.layout.placements[1].angle


def test_undo_and_redo_restore_the_document(document):
    result = reflatten(set_method(document, [1], "tutte"))
    assert apply_result(MapDocument.of(document.map), result).charts[1].method == "tutte"


def test_gain_is_reported_before_the_result_is_applied(document, reflattened):
    (gain,) = reflatten(set_method(reflattened, [1], "symmetric-dirichlet")).gains
    assert gain == pytest.approx(reflattened.charts[1].energies[-1] - document.charts[1].energies[-1])
    assert gain > 0
    unknown = replace(document.charts[1], energies=())
    job = replace(set_method(document, [1], "tutte").jobs[0], before=unknown)
    assert reflatten(replace(set_method(document, [1], "tutte"), jobs=(job,))).gains == (None,)


def test_progress_is_reported_and_may_cancel(document):
    reported = []
    reflatten(set_lengths(document, [0, 2], 0.5), progress=lambda text, share: reported.append((text, share)))
    assert {text for text, _ in reported} == {"Flattening patch 0", "Flattening patch 2"}
    assert {share for _, share in reported} == {0.0, 0.5}

    def cancel(_text, _share):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        reflatten(set_lengths(document, [0], 0.5), progress=cancel)


@pytest.mark.parametrize("lengths", [-0.1, 1.1, np.nan])
def test_share_of_lengths_outside_zero_to_one_is_rejected(document, lengths):
    with pytest.raises(MapError, match=r"share of lengths is out of range.*Choose 0 to 1"):
        set_lengths(document, [0], lengths)


def test_method_without_slider_rejects_and_resets_it(document, reflattened):
    with pytest.raises(MapError, match="no slider"):
        set_lengths(reflattened, [1], 0.5)
    slid = apply_result(document, reflatten(set_lengths(document, [0], 0.5)))
    assert set_method(slid, [0], "tutte").jobs[0].edit.lengths == 1.0
    with pytest.raises(MapError, match="unknown method"):
        set_method(document, [0], "by magic")


def test_pins_use_the_share_of_lengths_of_the_method(document):
    patch = document.patches[0]
    kept = [kept_lengths(replace(patch, method=name, lengths=0.3)) for name in ("symmetric-dirichlet", "lscm", "arap")]
    assert kept == [0.3, 0.0, 1.0]
    assert kept_lengths(replace(patch, method="by hand")) == 1.0


def test_imported_chart_is_kept_until_a_method_is_chosen(document):
    foreign = [replace(chart, method="by hand") for chart in document.charts]
    other = MapDocument.of(replace(document.map, charts=tuple(foreign)))
    same = apply_result(other, reflatten(request_reflatten(other, "Again", [(1, other.patches[1])], anyway=True)))
    np.testing.assert_array_equal(same.charts[1].plane, other.charts[1].plane)
    new = apply_result(other, reflatten(set_method(other, [1], "tutte")))
    assert new.charts[1].method == "tutte"


def test_pinned_patch_with_new_cuts_keeps_its_position(document):
    pinned = add_pin(add_pin(document, SurfacePoint(2, 3, (1.0, 0.0, 0.0))), SurfacePoint(2, 90, (0.2, 0.3, 0.5)))
    turned = rotate(pinned, [2], 0.8)
    held = [turned.map.to_map(pin.at) for pin in turned.patches[2].pins]
    new = apply_result(turned, reflatten(set_lengths(turned, [2], 0.0)))
    now = [new.map.to_map(pin.at) for pin in new.patches[2].pins]
    np.testing.assert_allclose(now, held, atol=0.003 * np.ptp(document.map.bounds))
    np.testing.assert_allclose(new.charts[2].plane.min(axis=0), 0, atol=1e-15)


def test_chart_is_aligned_with_another_chart_of_its_surface(document):
    chart = document.charts[0]
    other = replace(chart, plane=Placement(2.0, (0.3, -0.1)).apply(chart.plane))
    np.testing.assert_allclose(_laid_over(chart, other).plane, other.plane, atol=1e-12)
    assert _laid_over(chart, chart) is chart


def test_error_names_the_patch_that_cannot_be_reflattened(document):
    job = set_method(document, [1], "tutte").jobs[0]
    flat = replace(job.patch, surface=replace(job.patch.surface, vertices=job.patch.surface.vertices * 0))
    asked = replace(set_method(document, [1], "tutte"), jobs=(replace(job, patch=flat),))
    with pytest.raises(MapError, match="no area"):
        reflatten(asked)
    with pytest.raises(MapError, match="no area"):
        flatten_patch(flat)

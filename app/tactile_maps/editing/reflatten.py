"""Edits that need a patch flattened again: a request for the worker, the work, and its result put into the document.

A request is a plain value that crosses to another process. The window goes on with the old document meanwhile; the
result finds its place by what the patch was like when it was asked for, so that one that comes too late is recognised,
whatever was undone and redone in between. A result need not be put in: what it gains can be shown first.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import refreeze
from tactile_maps.core.errors import Finding, MapError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.editing.document import MapDocument, PatchEdit
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.methods import METHODS, find_method
from tactile_maps.flattening.newton import Iterate, OnRound
from tactile_maps.flattening.pinned_patch import PinnedPatch
from tactile_maps.maps.build import flatten_patch, with_chart
from tactile_maps.maps.model.layout import MapLayout, Placement, fit_placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch


class StaleEdit(MapError):
    """A result for a patch that has been changed since it was asked for; the document is as it was."""


@dataclass(frozen=True, eq=False)
class FlattenJob:
    """One patch to be flattened.

    Attributes:
        number: Of the patch.
        patch: Its surface.
        wanted: How.
        before: Its chart now.
        recut: Whether more is wanted otherwise than pins.
        stamp: What the patch is like now; see ``chart_fingerprint``.
    """

    number: int
    patch: Patch
    wanted: PatchEdit
    before: Chart
    recut: bool
    stamp: str


@dataclass(frozen=True, eq=False)
class ReflattenRequest:
    """An edit that has to be computed: give it to ``reflatten``, in any process.

    Attributes:
        name: Of the step, for the history.
        jobs: What is to be flattened; none if everything is as wanted already.
    """

    name: str
    jobs: tuple[FlattenJob, ...]


@dataclass(frozen=True, eq=False)
class ReflattenResult:
    """A request's result: ``apply_result`` puts it into the document.

    Attributes:
        request: What was asked for.
        charts: One for each job.
    """

    request: ReflattenRequest
    charts: tuple[Chart, ...]

    @property
    def gains(self) -> tuple[float | None, ...]:
        """By how much each job's mean symmetric Dirichlet energy fell; 4 is an isometry. None if it is not known."""
        pairs = zip(self.request.jobs, self.charts, strict=True)
        return tuple(
            job.before.energies[-1] - chart.energies[-1] if job.before.energies and chart.energies else None
            for job, chart in pairs
        )


def request_reflatten(
    document: MapDocument, name: str, wanted: Iterable[tuple[int, PatchEdit]], *, anyway: bool = False
) -> ReflattenRequest:
    """What must be computed for the patches to be as wanted; those that are already need nothing, unless ``anyway``."""
    jobs = []
    for number, edit in wanted:
        old = document.patches[number]
        if anyway or _recipe(edit) != _recipe(old):
            recut = _recipe(replace(edit, pins=())) != _recipe(replace(old, pins=()))
            patch = document.skin.patches[number]
            chart = document.charts[number]
            jobs.append(FlattenJob(number, patch, edit, chart, recut, chart_fingerprint(document, number)))
    return ReflattenRequest(name, tuple(jobs))


def set_method(document: MapDocument, numbers: Iterable[int], method: str) -> ReflattenRequest:
    """The patches flattened by another method; the slider goes back to lengths where the method has none.

    Raises:
        MapError: No such patch or method.
    """
    slides = find_method(method).slides
    wanted = {k: document.patches[k].lengths if slides else 1.0 for k in document.chosen(numbers)}
    edits = [(k, replace(document.patches[k], method=method, lengths=lengths)) for k, lengths in wanted.items()]
    return request_reflatten(document, "Method", edits)


def set_lengths(document: MapDocument, numbers: Iterable[int], lengths: float) -> ReflattenRequest:
    """The patches' slider between angles (0) and lengths (1).

    Raises:
        MapError: No such patch, a value outside 0 to 1, or a method that has no slider.
    """
    if not 0 <= lengths <= 1:
        raise MapError("the slider between angles and lengths goes from 0 to 1", value=lengths)
    chosen = document.chosen(numbers)
    for patch in (document.patches[k] for k in chosen):
        if not find_method(patch.method).slides:
            remedy = "Choose the method symmetric-dirichlet"
            raise MapError("this method has no slider", place=patch.name, value=patch.method, remedy=remedy)
    edits = [(k, replace(document.patches[k], lengths=float(lengths))) for k in chosen]
    return request_reflatten(document, "Angles and lengths", edits)


def reflatten(wanted: ReflattenRequest, *, progress: Progress = no_progress) -> ReflattenResult:
    """Compute what a request asks for: a new chart for each of its patches.

    Args:
        wanted: From any of the edits.
        progress: Told what is being done and how far it is, 0 to 1, at least once a round; may raise to cancel.

    Raises:
        MapError: A patch cannot be flattened in this way; the document keeps what it had.

    Cost: as ``build_map`` for these patches.
    """
    charts: list[Chart] = []
    for done, job in enumerate(wanted.jobs):
        text = f"Flattening {job.wanted.name}"
        share = done / len(wanted.jobs)

        def report(_iterate: Iterate, text: str = text, share: float = share) -> None:
            progress(text, share)

        progress(text, share)
        charts.append(_chart(job, report))
    return ReflattenResult(wanted, tuple(charts))


def _chart(job: FlattenJob, on_round: OnRound) -> Chart:
    how = job.wanted
    chart = job.before
    if job.recut or (not how.pins and how.method in METHODS):
        chart = flatten_patch(job.patch, method=how.method, lengths=how.lengths, seams=how.seams, on_round=on_round)
        chart = replace(chart, findings=(*chart.findings, *_unwanted(job, chart)))
    if not how.pins:
        return chart
    start = _laid_over(chart, job.before)
    pinned = PinnedPatch(job.patch.surface, start, lengths=kept_lengths(how), pins=how.pins, name=how.name)
    return pinned.converge(on_round=on_round)


def kept_lengths(edit: PatchEdit) -> float:
    """From 1, keep lengths, to 0, keep angles: what is kept between pins, whatever the method."""
    method = METHODS.get(edit.method)
    return edit.lengths if method is None or method.slides else method.lengths


def _laid_over(chart: Chart, other: Chart) -> Chart:
    """``chart`` turned and moved to lie on ``other``, of the same surface but maybe cut otherwise."""
    if chart is other:
        return chart
    ours = chart.plane[chart.faces].reshape(-1, 2)
    theirs = other.plane[other.faces].reshape(-1, 2)
    return replace(chart, plane=fit_placement(ours, theirs, rigid=True).apply(chart.plane))


def _unwanted(job: FlattenJob, chart: Chart) -> list[Finding]:
    """What the patch's topology took although a person would rather not."""
    plan = job.wanted.seams
    found = []
    if plan.extra == 0:
        drawn = {tuple(edge) for edge in np.sort(plan.drawn, axis=1).tolist()}
        more = sum(tuple(edge) not in drawn for edge in np.sort(chart.seams, axis=1).tolist())
        if more:
            found.append(
                Finding(
                    "seam-needed", job.wanted.name, "additional seam: without it the patch cannot be flattened", more
                )
            )
    if plan.importance is not None:
        through = int((plan.importance[chart.seams] > 0).all(axis=1).sum())
        if through:
            found.append(Finding("seam-in-interest", job.wanted.name, "no seam around it exists", through))
    return found


def apply_result(document: MapDocument, result: ReflattenResult) -> MapDocument:
    """The document with the result in it: charts where the old ones lay; names and visibility as they are now.

    Raises:
        StaleEdit: A patch is not as it was when the result was asked for.
    """
    refreeze(result)
    for job, chart in zip(result.request.jobs, result.charts, strict=True):
        if chart_fingerprint(document, job.number) != job.stamp:
            name = document.patches[job.number].name
            raise StaleEdit("the patch was changed meanwhile", place=name, remedy="Do the edit again")
        now = document.patches[job.number]
        edit = replace(job.wanted, name=now.name, visible=now.visible)
        if edit.pins:
            document = with_chart_in_frame(document, job.number, chart, edit)
        else:
            document = replace(document, map=with_chart(document.map, job.number, chart)).with_patch(job.number, edit)
    return document


def with_chart_in_frame(document: MapDocument, number: int, chart: Chart, edit: PatchEdit) -> MapDocument:
    """The document with a chart and its pins in the old chart's frame, so that both stay where they are on the map.

    The chart's box comes to the origin, as every chart's; pins and placement make up for it.
    """
    corner = chart.plane.min(axis=0)
    x, y = (float(value) for value in corner)
    pins = tuple(replace(pin, place=(pin.place[0] - x, pin.place[1] - y)) for pin in edit.pins)
    charts = list(document.charts)
    placements = list(document.layout.placements)
    charts[number] = replace(chart, plane=chart.plane - corner)
    placements[number] = placements[number].after(Placement(offset=(x, y)))
    map_ = TactileMap(document.skin, tuple(charts), MapLayout(tuple(placements)))
    return replace(document, map=map_).with_patch(number, replace(edit, pins=pins))


def chart_fingerprint(document: MapDocument, number: int) -> str:
    """What a patch's chart is and how it came about, in few letters: the same for the same, in every process.

    Where the patch lies, its name and whether it is shown do not count. Cost: 0.2 ms for 10,000 faces.
    """
    if number not in range(len(document.patches)):
        return ""
    chart = document.charts[number]
    digest = hashlib.blake2b(digest_size=16)
    for array in (chart.plane, chart.faces):
        digest.update(np.ascontiguousarray(array).tobytes())
    return f"{digest.hexdigest()} {_recipe(document.patches[number])}"


def _recipe(edit: PatchEdit) -> str:
    """What makes the chart, in few letters."""
    seams = edit.seams
    pins = [(pin.at.face, *map(float, (*pin.at.weights, *pin.place))) for pin in edit.pins]
    parts = [edit.method, float(edit.lengths), seams.extra, pins, seams.drawn.tolist()]
    digest = hashlib.blake2b(repr(parts).encode(), digest_size=16)
    if seams.importance is not None:
        digest.update(seams.importance.tobytes())
    return digest.hexdigest()

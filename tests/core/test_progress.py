"""Progress of a part is reported as its share of the whole."""

from __future__ import annotations

from tactile_maps.core.progress import no_progress, part_of_progress


def test_partial_progress_covers_its_share():
    heard: list[tuple[str, float]] = []
    part = part_of_progress(lambda text, fraction: heard.append((text, fraction)), 0.25, 0.75)
    inner = part_of_progress(part, 0.5, 1.0)
    part("begin", 0.0)
    inner("half way", 0.0)
    inner("end", 1.0)
    assert heard == [("begin", 0.25), ("half way", 0.5), ("end", 0.75)]


def test_progress_may_be_ignored():
    assert no_progress("", 0.5) is None

"""Tables come a few frames at a time, with names that are all different."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.progress import no_progress
from tactile_maps.export import tables
from tactile_maps.export.tables import BATCH, episodes, highest_reading, paced_frames, taxel_labels, write_tables
from tactile_maps.recording.encoding.frame_codec import decode_frame, encode_frame
from tactile_maps.skin.model.skin import TaxelIdentity
from tests.support.recordings import small_arm


class Counting:
    """A sink that keeps only how many rows came at a time."""

    def __init__(self):
        self.rows = {}

    def append(self, table, columns):
        lengths = {len(values) for values in columns.values()}
        assert len(lengths) == 1
        self.rows.setdefault(table, []).append(lengths.pop())


def test_at_most_one_batch_is_in_memory(player):
    sink = Counting()
    shares = []
    write_tables(player, sink, image_width=8, progress=lambda text, share: shares.append(share))
    assert max(sink.rows["pressures"]) == max(sink.rows["images"]) == BATCH
    assert sum(sink.rows["frames"]) == len(player)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


class Kept:
    """A sink that keeps the columns of one table."""

    def __init__(self, table):
        self.table = table
        self.columns = {}

    def append(self, table, columns):
        if table == self.table:
            for name, values in columns.items():
                self.columns.setdefault(name, []).extend(values.tolist())


def test_taxels_of_a_contact_match_its_area(player, frames):
    kept = Kept("contacts")
    write_tables(player, kept, image_width=0, progress=lambda _text, _share: None)
    regions = [region for frame in frames for region in frame.regions]
    assert len(regions) > 50
    assert kept.columns["taxels"] == [region.touched for region in regions]
    assert any(region.touched < len(region.taxels) for region in regions)
    areas = player.prepared.skin.areas
    for region in regions:
        own = np.sort(areas[region.taxels])
        assert own[: region.touched].sum() <= region.area + 1e-12
        assert region.area <= own[::-1][: region.touched].sum() + 1e-12


def test_taxels_of_a_contact_are_unknown_in_recordings_that_do_not_store_them(player):
    class Older:
        """The recording as an earlier version wrote it."""

        def __getattr__(self, name):
            return getattr(player, name)

        def __len__(self):
            return len(player)

        def __iter__(self):
            for frame in player:
                regions = tuple(replace(region, touched=None) for region in frame.regions)
                yield decode_frame(encode_frame(replace(frame, regions=regions)), player.prepared)

    kept = Kept("contacts")
    write_tables(Older(), kept, image_width=0, progress=lambda _text, _share: None)
    assert set(kept.columns["taxels"]) == {-1}


def test_paced_frames_include_all_frames_and_events_and_images_at_the_rate(player, frames, monkeypatch):
    monkeypatch.setattr(tables, "BATCH", 7)
    found = list(paced_frames(player, 25.0, no_progress))
    assert [frame.tick for frame, _, _ in found] == [frame.tick for frame in frames]
    assert [event for _, _, events in found for event in events] == player.events
    every = round(1 / (25.0 * player.prepared.scene.tick))
    pictures = [frame.tick for frame, due, _ in found if due]
    assert pictures == [frame.tick for frame in frames if frame.tick % every == 0]


def test_labels_are_unique_even_if_ids_repeat_or_are_missing():
    skin = small_arm().skin
    assert taxel_labels(skin) == [f"taxel_{taxel}" for taxel in range(len(skin))]
    patch = skin.patches[0]
    count = len(patch.taxels)
    identity = TaxelIdentity(ids=np.r_[7, 7, 10 + np.arange(count - 2)])
    some = replace(skin, patches=(replace(patch, taxels=replace(patch.taxels, identity=identity)), *skin.patches[1:]))
    labels = taxel_labels(some)
    assert labels[:3] == ["id_7_taxel_0", "id_7_taxel_1", "id_10"]
    assert labels[count] == f"taxel_{count}"
    assert len(set(labels)) == len(labels)


def test_recording_without_a_gap_is_one_episode(player):
    (one,) = episodes(player)
    assert (one.first, one.frames) == (0, len(player))


def test_search_for_the_highest_reading_reports_progress_and_can_be_cancelled(player):
    shares = []
    highest = highest_reading(player, lambda _, share: shares.append(share))
    assert highest == max(float(frame.pressures.max()) for frame in player)
    assert shares[0] == 0.0
    assert shares == sorted(shares)

    def cancel(_text, _share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        highest_reading(player, cancel)

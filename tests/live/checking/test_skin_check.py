"""Guided check: parts are pressed in order, other parts respond or nothing does, and channels are judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.checking.parts import parts_of
from tactile_maps.live.checking.report import board_rows
from tactile_maps.live.checking.skin_check import CheckSettings, CheckStage, Outcome, SkinCheck
from tactile_maps.live.checking.verdicts import ChannelFault, verdicts_of
from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tests.support.pressed_stream import pressed, skin_with_modules
from tests.support.touch import bar_skin

SKIN = skin_with_modules()
PARTS = [part.taxels for part in parts_of(SKIN)]


def run(touches=PARTS, *, skin=SKIN, settings=None, **stream):
    """Return the check of a stream, finished at its end."""
    check = SkinCheck(skin, settings)
    for values, time in pressed(skin, touches, **stream):
        check.add(values, time)
    check.finish()
    return check


def outcomes(check):
    return [result.outcome for result in check.results]


def faults(check):
    """Return the faulty taxels by fault."""
    return {fault: np.flatnonzero(those).tolist() for fault, those in verdicts_of(check).faults.items() if those.any()}


def test_parts_are_modules_or_groups_of_adjacent_taxels_or_single_taxels():
    assert [part.name for part in parts_of(SKIN)] == ["module 10", "module 11", "module 12", "module 13"]
    assert [len(part.taxels) for part in parts_of(bar_skin(60))] == [30, 30]
    assert parts_of(bar_skin(60))[1].name == "group 2 of patch top"
    assert [part.taxels.tolist() for part in parts_of(bar_skin(6))] == [[k] for k in range(6)]
    assert np.array_equal(np.sort(np.concatenate([part.taxels for part in parts_of(bar_skin(60))])), np.arange(60))


@pytest.mark.parametrize("unit", [1.0, 0.01], ids=["counts", "large unit"])
def test_working_skin_is_checked_without_keys_and_has_no_faults(unit):
    check = run(settings=CheckSettings(least=unit), noise=unit, force=100 * unit)
    assert check.stage is CheckStage.DONE
    assert outcomes(check) == [Outcome.FELT] * 4
    assert faults(check) == {}


def test_part_is_completed_when_all_its_taxels_responded_or_after_the_pause():
    check = SkinCheck(SKIN)
    first, second = PARTS[:2]
    steps = []
    for values, time in pressed(SKIN, [first[:6], first[6:], second[:6]], gap=1.0):
        check.add(values, time)
        steps.append((check.stage, check.current, len(check.missing), len(check.pressed)))
    assert steps[0] == (CheckStage.REST, 0, 0, 0)
    assert (CheckStage.PRESS, 0, 6, 6) in steps
    assert (CheckStage.PRESS, 1, 12, 0) in steps
    assert steps[-1] == (CheckStage.PRESS, 1, 6, 6)
    check.add(values, time + 2.0)
    assert (check.current, check.results[1].outcome) == (2, Outcome.FELT)


def test_dead_channel_is_silent_among_responding_neighbours_and_stuck_one_above_them():
    def change(values, number):
        values[dead] = 200.0
        values[stuck] = 1023.0
        return values

    dead, stuck = PARTS[1][4], PARTS[2][5]
    check = run(change=change)
    assert outcomes(check) == [Outcome.FELT] * 4
    assert faults(check) == {ChannelFault.DEAD: [dead], ChannelFault.STUCK: [stuck]}


def test_channel_that_shows_only_noise_is_dead():
    def change(values, number):
        values[dead] = min(values[dead], 203.0)
        return values

    dead = PARTS[1][4]
    assert faults(run(change=change)) == {ChannelFault.DEAD: [dead]}


def test_channel_whose_noise_would_hide_the_touch_is_not_reported_as_dead():
    random = np.random.default_rng(6)

    def change(values, number):
        values[one] = 200.0 + 15.0 * random.standard_normal()
        return values

    one = PARTS[1][4]
    found = faults(run(change=change))
    assert ChannelFault.DEAD not in found
    assert found[ChannelFault.NOT_FELT] == [one]


def test_part_without_response_is_skipped_after_the_timeout_with_all_channels_dead():
    check = run([PARTS[0], [], [], [], [], PARTS[2], PARTS[3]], settings=CheckSettings(patience=10.0))
    assert outcomes(check) == [Outcome.FELT, Outcome.NOTHING, Outcome.FELT, Outcome.FELT]
    assert 10.0 <= check.results[1].seconds < 10.1
    assert faults(check) == {ChannelFault.DEAD: PARTS[1].tolist()}


def test_channel_that_was_not_pressed_is_not_reported_as_dead():
    """A touch of one end of the last module says nothing about its other taxels."""
    end = PARTS[3][np.argsort(SKIN.patches[0].taxels.positions[PARTS[3], 0])]
    assert faults(run([*PARTS[:3], end[:3]])) == {ChannelFault.NOT_FELT: sorted(end[3:])}


def test_noisy_channel_is_named_and_does_not_count_as_a_touch():
    random = np.random.default_rng(5)

    def change(values, number):
        values[noisy] += 40.0 * random.standard_normal()
        return values

    noisy = PARTS[2][3]
    check = run(change=change)
    assert outcomes(check) == [Outcome.FELT] * 4
    assert faults(check)[ChannelFault.NOISY] == [noisy]
    assert check.noise[noisy] > 20


@pytest.mark.parametrize(("top", "noise"), [(280.0, 1.0), (255.0, 0.0)], ids=["without noise", "full scale"])
def test_channels_that_remain_at_one_value_under_pressure_are_saturated(top, noise):
    """Every pressed channel keeps one value without noise; then only the full scale of a converter is suspect."""

    def change(values, number):
        values[pair] = np.minimum(values[pair], top)
        return values

    pair = PARTS[0][2:4]
    assert faults(run(change=change, noise=noise)) == {ChannelFault.SATURATED: pair.tolist()}


def test_inverted_channels_change_against_the_others_and_a_falling_skin_is_stated():
    def change(values, number):
        values[one] = 400.0 - values[one]
        return values

    one = PARTS[1][2]
    check = run(change=change)
    assert faults(check) == {ChannelFault.INVERTED: [one]}
    assert not verdicts_of(check).falls
    falling = run(change=change, force=-100.0)
    assert faults(falling) == {ChannelFault.INVERTED: [one]}
    assert verdicts_of(falling).falls


def test_two_swapped_modules_are_named_after_each_has_responded_twice_for_the_other():
    touches = [PARTS[3], PARTS[3], PARTS[1], PARTS[2], PARTS[0], PARTS[0]]
    check = run(touches)
    assert outcomes(check) == [Outcome.OTHER, Outcome.FELT, Outcome.FELT, Outcome.OTHER]
    assert [check.results[0].others, check.results[3].others] == [(3,), (0,)]
    (swap,) = verdicts_of(check).swaps
    assert swap.parts == ("module 10", "module 13")


@pytest.mark.parametrize(("value", "fault"), [(200.0, ChannelFault.DEAD), (1023.0, ChannelFault.STUCK)])
def test_two_swapped_modules_are_named_although_a_channel_does_not_respond(value, fault):
    def change(values, number):
        values[silent] = value
        return values

    silent = PARTS[3][4]
    check = run([PARTS[3], PARTS[3], PARTS[1], PARTS[2], PARTS[0], PARTS[0]], change=change)
    (swap,) = verdicts_of(check).swaps
    assert swap.parts == ("module 10", "module 13")
    swapped = sorted({*PARTS[0].tolist(), *PARTS[3].tolist()} - {silent})
    assert faults(check) == {fault: [silent], ChannelFault.SWAPPED: swapped}


def test_response_of_another_part_must_repeat_before_it_counts():
    check = run([PARTS[3], PARTS[0], *PARTS[1:]])
    assert outcomes(check) == [Outcome.FELT] * 4
    assert faults(check) == {}


def test_two_swapped_channels_of_different_modules_are_named():
    def change(values, number):
        values[[a, b]] = values[[b, a]]
        return values

    a, b = PARTS[0][3], PARTS[3][4]
    check = run(change=change)
    (swap,) = verdicts_of(check).swaps
    assert (swap.first, swap.second, swap.parts) == ((a,), (b,), ())
    assert faults(check) == {ChannelFault.SWAPPED: sorted([a, b])}


def test_touch_of_two_distant_modules_does_not_count_for_the_requested_one():
    both = np.concatenate([PARTS[0], PARTS[3]])
    check = SkinCheck(SKIN)
    for values, time in pressed(SKIN, [both]):
        check.add(values, time)
    assert check.current == 0
    assert check.note == "Several parts were felt: module 10, module 13."
    check = run([both, both, *PARTS[1:]])
    assert outcomes(check) == [Outcome.SEVERAL, *[Outcome.FELT] * 3]
    assert check.results[0].others == (3,)


def test_source_that_ends_leaves_the_remaining_parts_open_and_names_no_fault_of_theirs():
    check = run(PARTS[:2])
    assert outcomes(check) == [Outcome.FELT, Outcome.FELT, Outcome.OPEN, Outcome.OPEN]
    assert faults(check) == {}
    with pytest.raises(LiveError, match=r"before the skin at rest was measured \(found: 20 readings\)"):
        run([], rest=1.0)


def test_next_skip_and_back_change_the_current_part():
    check = SkinCheck(SKIN)
    check.next()
    for values, time in pressed(SKIN, []):
        check.add(values, time)
    assert (check.stage, check.current) == (CheckStage.PRESS, 0)
    check.skip()
    check.next()
    assert outcomes(check)[:2] == [Outcome.SKIPPED, Outcome.NOTHING]
    check.back()
    check.back()
    check.back()
    assert (check.current, outcomes(check)) == (0, [Outcome.OPEN] * 4)
    for _ in PARTS:
        check.skip()
    assert check.stage is CheckStage.DONE
    check.back()
    assert (check.stage, check.current) == (CheckStage.PRESS, 3)


def test_recording_of_any_touches_names_only_dead_channels_among_responding_neighbours():
    def change(values, number):
        values[dead] = 200.0
        return values

    dead = PARTS[1][4]
    check = run([PARTS[2], PARTS[1]], change=change, settings=CheckSettings(ordered=False))
    assert outcomes(check) == [Outcome.OPEN, Outcome.FELT, Outcome.FELT, Outcome.OPEN]
    assert check.touches == 2
    found = faults(check)
    assert dead in found[ChannelFault.DEAD]
    far = PARTS[0][np.argmin(SKIN.patches[0].taxels.positions[PARTS[0], 0])]
    assert all(far not in those for those in found.values())


def test_slow_recovery_of_a_cover_is_not_another_touch():
    residue = np.zeros(len(SKIN))

    def change(values, number):
        residue[:] = np.where(values > 250.0, 20.0, residue * np.exp(-0.05 / 2.0))
        return values + residue

    check = run(change=change)
    assert outcomes(check) == [Outcome.FELT] * 4
    assert faults(check) == {}
    assert check.touches == 4


def test_channel_without_a_value_is_not_received_and_drift_is_not_a_touch():
    def change(values, number):
        values += 0.05 * number
        values[lost] = np.nan
        return values

    lost = PARTS[0][1]
    check = run(change=change)
    assert outcomes(check) == [Outcome.FELT] * 4
    assert faults(check) == {ChannelFault.UNHEARD: [lost]}


def icub_skin(taxels=384, stream=384):
    """Return the bar's skin as two boards of iCub with sixteen modules of twelve channels each."""
    skin = bar_skin(taxels)
    (patch,) = skin.patches
    along = np.argsort(np.argsort(patch.taxels.positions[:, 0], kind="stable"), kind="stable")
    identity = TaxelIdentity(along, along // 12, along % 12, stream=stream)
    return Skin((replace(patch, taxels=replace(patch.taxels, identity=identity)),))


def test_board_of_which_no_channel_responds_is_named_with_its_modules():
    skin = icub_skin()
    second = skin.identity.ids >= 192

    def change(values, number):
        return np.where(second, 200.0, values)

    check = run(
        [part.taxels for part in parts_of(skin)], skin=skin, settings=CheckSettings(patience=2.0), change=change
    )
    rows = board_rows(check, verdicts_of(check))
    link = skin.patches[0].link
    assert [row["board"] for row in rows] == [f"board 0 of {link}", f"board 1 of {link}"]
    assert [row["modules"] for row in rows] == ["0-15", "16-31"]
    assert [row["felt"] for row in rows] == ["192 of 192", "0 of 192"]
    assert [row["verdict"] for row in rows] == ["responds", "no channel responds: check its cable and supply"]


@pytest.mark.parametrize("skin", [SKIN, icub_skin(stream=None), icub_skin(stream=385)], ids=["bar", "none", "other"])
def test_boards_are_not_named_for_streams_of_other_skins(skin):
    check = run([], skin=skin)
    assert board_rows(check, verdicts_of(check)) == []

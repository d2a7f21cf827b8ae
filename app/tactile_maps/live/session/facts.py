"""Facts about the readings of a real skin, to display to the user."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import names_text
from tactile_maps.live.calibration.calibration import ValueMode
from tactile_maps.live.calibration.weighing import WeighingState
from tactile_maps.live.channels.channel_health import SilentChannel
from tactile_maps.live.channels.channel_swaps import SwappedChannels
from tactile_maps.live.readings.readings import Unit
from tactile_maps.skin.model.skin import Skin


@dataclass(frozen=True)
class MeasuredFacts:
    """Facts about the readings to display to the user, other than contacts.

    Attributes:
        readings: Number of readings used so far.
        refused: Number of readings that did not fit the skin.
        problem: Error of the newest rejected reading; None if there was none.
        unknown: Sorted labels that belong to no taxel.
        unknown_values: Number of values with such a label.
        ambiguous: Sorted labels that belong to several taxels, with the labels that distinguish these.
        ambiguous_values: Number of values with such a label.
        unheard: Number of taxels without a value so far.
        unknown_joints: Sorted names of joints that the robot does not have.
        unheard_joints: Number of the robot's joints without a position so far; they are displayed in the home posture.
        silent: Channels that do not follow the skin.
        swapped: Channels that are exchanged.
        unit: Unit of the newest reading.
        mode: Displayed quantity.
        calibrated: Whether calibrated pressures and forces are displayed.
        known: Whether there is a calibration to display them with.
        mistimed: Number of readings with an implausible time, for which the time of arrival was used.
        combined: Number of readings without a frame of their own, because newer ones were waiting.
        taring: Whether the baseline is being measured.
        tared: Whether there is a baseline.
        awaits_tare: Whether no contact is detected before a tare.
        weighing: Progress of a calibration with a known weight.
        inverted: Whether values that fall count as pressure.
        falling: Whether values fall below the baseline where the skin seems to be touched.
        falling_taxels: Names of these taxels.
        touched_in_tare: Names of taxels that were touched during a part of the tare, which was left out for them.
        held_in_tare: Names of taxels that may have been touched during all of the tare.
        wrong_channels: Taxels that sent too few or too many of the channels pressure, t1 and t2.
        wrong_channel_values: Number of their values.
    """

    readings: int
    refused: int
    problem: str | None
    unknown: tuple[str, ...]
    unknown_values: int
    ambiguous: tuple[str, ...]
    ambiguous_values: int
    unheard: int
    unknown_joints: tuple[str, ...]
    unheard_joints: int
    silent: tuple[SilentChannel, ...]
    swapped: tuple[SwappedChannels, ...]
    unit: Unit | None
    mode: ValueMode
    calibrated: bool
    known: bool
    mistimed: int
    combined: int
    taring: bool
    tared: bool
    awaits_tare: bool
    weighing: WeighingState
    inverted: bool
    falling: bool
    falling_taxels: tuple[str, ...]
    touched_in_tare: tuple[str, ...]
    held_in_tare: tuple[str, ...]
    wrong_channels: tuple[str, ...]
    wrong_channel_values: int


_FEW = 0.75
"""Share of the skin's taxels below which readings are probably of another skin; single channels may be dead."""


def few_heard(facts: MeasuredFacts, taxels: int) -> str | None:
    """Return in words that a large share of the skin's ``taxels`` sent no value; None if most did or none was read."""
    heard = taxels - facts.unheard
    if not facts.readings or heard >= _FEW * taxels:
        return None
    return f"the readings have values of only {heard} of the skin's {taxels} taxels"


def held_text(taxels: Sequence[str]) -> str:
    """Return a sentence about the taxels that seem to have been touched during all of a tare."""
    return f"During the tare something seems to have touched {names_text(taxels)}: contacts there are hidden."


def tare_doubt(facts: MeasuredFacts) -> str:
    """Return why the tare may hide contacts or show wrong ones, one sentence per reason; empty without a doubt."""
    texts = []
    if facts.held_in_tare:
        texts.append(held_text(facts.held_in_tare))
    if facts.falling:
        names = names_text(facts.falling_taxels)
        texts.append(
            f"Readings of {names} fall below their baseline: they are inverted, or something touched the skin during "
            "the tare."
        )
    return " ".join(texts)


def taxel_names(skin: Skin, taxels: IntArray) -> tuple[str, ...]:
    """Return the names of taxels (k,) of a skin, in their order."""
    return tuple(map(skin.taxel_text, taxels.tolist()))


def swapped_texts(skin: Skin, swapped: tuple[SwappedChannels, ...]) -> tuple[str, ...]:
    """Return swapped channels in words by module, like "module 14: 87012 with 87015"."""
    by_module: dict[int | None, list[str]] = {}
    for one in swapped:
        pair = f"{skin.taxel_text(one.first)} with {skin.taxel_text(one.second)}"
        by_module.setdefault(one.module, []).append(pair)
    return tuple(
        ("" if module is None else f"module {module}: ") + ", ".join(pairs) for module, pairs in by_module.items()
    )


def silent_text(skin: Skin, silent: SilentChannel) -> str:
    """Return a silent channel in words: its name and value."""
    return f"{skin.taxel_text(silent.taxel)}: {'stuck' if silent.stuck else 'dead'} at {silent.value:g}"

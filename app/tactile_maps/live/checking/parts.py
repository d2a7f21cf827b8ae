"""Parts of a skin that are pressed one at a time: its modules, or groups of adjacent taxels where it states none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.skin.formats.icub.positions import ROWS_PER_MODULE
from tactile_maps.skin.model.skin import Skin, TaxelIdentity

_SINGLE_TAXELS = 24
"""Largest skin without modules whose taxels are pressed one by one."""
_LARGEST_GROUP = 32
"""Largest number of taxels of a group without modules: about what a hand presses in a few seconds."""
_BOARD_VALUES = 192
"""Number of values of one of iCub's boards in its stream: sixteen modules of twelve."""


@dataclass(frozen=True, eq=False)
class SkinPart(ArrayFields):
    """Taxels that are pressed together.

    Attributes:
        name: Displayed name, such as ``module 14``.
        link: Link that carries them.
        taxels: (k,) their numbers, ascending.
        module: Their module; None where the skin states none.
        board: Number of the board that reads the module; None where the skin's stream is not one of iCub's boards.
    """

    name: str
    link: str
    taxels: IntArray
    module: int | None = None
    board: int | None = None

    @property
    def board_name(self) -> str:
        """Displayed name of the board; empty where it is unknown."""
        return "" if self.board is None else f"board {self.board} of {self.link}"


def parts_of(skin: Skin) -> tuple[SkinPart, ...]:
    """Return the parts of a skin, patch by patch: modules in ascending order, or else groups of adjacent taxels.

    A skin without modules and with at most 24 taxels has one part for each taxel; the patches of larger ones are halved
    along their longest side until a group has at most 32 taxels.
    """
    parts = list[SkinPart]()
    for link in skin.links:
        patches = [number for number, patch in enumerate(skin.patches) if patch.link == link]
        where = f" ({link})" if len(skin.links) > 1 else ""
        with_modules = [k for k in patches if skin.patches[k].taxels.identity.modules is not None]
        parts += _modules(skin, link, with_modules, where)
        for number in (k for k in patches if k not in with_modules):
            parts += _groups(skin, number, where)
    return tuple(parts)


def adjacent_parts(skin: Skin, parts: tuple[SkinPart, ...]) -> BoolArray:
    """(parts, parts) whether two parts have neighbouring taxels."""
    part_of = part_numbers(skin, parts)
    pairs = part_of[skin.neighbours]
    adjacent = np.zeros((len(parts), len(parts)), dtype=bool)
    adjacent[pairs[:, 0], pairs[:, 1]] = adjacent[pairs[:, 1], pairs[:, 0]] = True
    return adjacent


def part_numbers(skin: Skin, parts: tuple[SkinPart, ...]) -> IntArray:
    """(taxels,) number of the part of each taxel."""
    numbers = np.zeros(len(skin), dtype=np.int64)
    for number, part in enumerate(parts):
        numbers[part.taxels] = number
    return numbers


def _modules(skin: Skin, link: str, patches: list[int], where: str) -> list[SkinPart]:
    if not patches:
        return []
    taxels = np.concatenate([np.arange(skin.first[k], skin.first[k + 1]) for k in patches])
    modules = np.concatenate([skin.patches[k].taxels.identity.modules for k in patches])
    boards = np.concatenate([_boards(skin.patches[k].taxels.identity) for k in patches])
    parts = []
    for module in np.unique(modules).tolist():
        own = modules == module
        board = int(boards[own].min())
        name = f"module {module}{where}"
        parts.append(SkinPart(name, link, np.sort(taxels[own]), module, board if board >= 0 else None))
    return parts


def _boards(identity: TaxelIdentity) -> IntArray:
    """(n,) board of each taxel of a patch with modules, by its place in a stream of iCub's boards; -1 if unknown."""
    ids = identity.ids
    modules = identity.modules
    assert modules is not None
    of_icub = ids is not None and identity.stream is not None and identity.stream % _BOARD_VALUES == 0
    if ids is None or not of_icub or (modules != ids // ROWS_PER_MODULE).any():
        return np.full(len(modules), -1)
    return np.asarray(ids // _BOARD_VALUES)


def _groups(skin: Skin, patch: int, where: str) -> list[SkinPart]:
    numbers = np.arange(skin.first[patch], skin.first[patch + 1])
    own = skin.patches[patch]
    if len(skin) <= _SINGLE_TAXELS:
        names = map(skin.taxel_text, numbers.tolist())
        return [SkinPart(f"{name}{where}", own.link, one) for name, one in zip(names, numbers[:, None], strict=True)]
    groups = _halved(own.taxels.positions, np.arange(len(numbers)))
    if len(groups) == 1:
        return [SkinPart(f"patch {own.name}{where}", own.link, numbers)]
    return [
        SkinPart(f"group {count} of patch {own.name}{where}", own.link, np.sort(numbers[group]))
        for count, group in enumerate(groups, start=1)
    ]


def _halved(positions: FloatArray, rows: IntArray) -> list[IntArray]:
    """Return groups of at most ``_LARGEST_GROUP`` rows, in order along the longest side."""
    if len(rows) <= _LARGEST_GROUP:
        return [rows]
    centred = positions[rows] - positions[rows].mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    axis = axis * np.sign(axis[np.argmax(np.abs(axis))])  # the same order on every machine
    order = rows[np.argsort(centred @ axis, kind="stable")]
    half = len(order) // 2
    return _halved(positions, order[:half]) + _halved(positions, order[half:])

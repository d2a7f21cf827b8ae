"""The patch tree: names, what is shown, and in which order. The map itself stays as it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from app.editing.document import MapDocument
from app.errors import MapError

LONGEST = 100
"""Characters of a name."""


def rename(document: MapDocument, number: int, name: str) -> MapDocument:
    """Patch ``number`` called ``name``; spaces at the ends do not count.

    Raises:
        MapError: No such patch, or a name that is empty, too long, of more than one line, or another patch's.
    """
    (number,), wanted = document.chosen([number]), name.strip()
    if not wanted or len(wanted) > LONGEST or not wanted.isprintable():
        raise MapError("that is no name for a patch", value=name, remedy=f"Write 1 to {LONGEST} characters")
    if any(patch.name == wanted for k, patch in enumerate(document.patches) if k != number):
        raise MapError("another patch has this name", value=wanted, remedy="Choose another name")
    if wanted == document.patches[number].name:
        return document
    return document.with_patch(number, replace(document.patches[number], name=wanted))


def show(document: MapDocument, numbers: Iterable[int], *, visible: bool = True) -> MapDocument:
    """The patches shown, or hidden: they feel and are controlled all the same."""
    for number in document.chosen(numbers):
        if document.patches[number].visible != visible:
            document = document.with_patch(number, replace(document.patches[number], visible=visible))
    return document


def reorder(document: MapDocument, number: int, to: int) -> MapDocument:
    """Patch ``number`` at place ``to`` of the tree, 0 first; the others keep their order.

    Raises:
        MapError: No such patch or no such place.
    """
    (number,) = document.chosen([number])
    if not 0 <= to < len(document.order):
        raise MapError("there is no such place in the tree", value=to, remedy=f"0 to {len(document.order) - 1}")
    rest = [k for k in document.order if k != number]
    order = (*rest[:to], number, *rest[to:])
    return document if order == document.order else replace(document, order=order)

"""What the editor tells whoever shows the document: facts, as signals. What a hand wants goes in by methods instead."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from app.editing.reflatten import Reflattened


@dataclass(frozen=True, eq=False)
class Proposal:
    """A computed edit that waits to be accepted.

    Attributes:
        result: What ``apply`` would put in.
        gain: Share of the patch's distortion that it takes away; nan if that is not known.
    """

    result: Reflattened
    gain: float


class EditorFacts(QObject):
    """Past-tense changes of the document; none asks for an answer."""

    shown = Signal(object)
    """The MapDocument as it is now, in a gesture as the hand has it."""
    settled = Signal(object, str)
    """The MapDocument and the name of the step that was done, undone or redone; never within a gesture."""
    history_changed = Signal()
    """Other steps, or another place among them."""
    selection_changed = Signal()
    """Other patches are selected."""
    working = Signal(str, float)
    """An edit is being computed: what, and 0 to 1."""
    rested = Signal()
    """It is not any more: done, failed or cancelled."""
    failed = Signal(str)
    """An edit was refused; the sentence says why. The document is as it was."""
    told = Signal(str)
    """Something worth a line."""
    proposal_changed = Signal()
    """A proposal waits, or no longer."""
    enabled_changed = Signal(bool)
    """Whether edits are taken from now on."""

"""The Skin panel: the links that are covered, and number, pattern and margin of their taxels.

The panel holds a choice that differs from the shown skin until it is applied. It fits nothing; its owner shows the
numbers of taxels of a preview.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QWidget

from tactile_maps.core.errors import counted
from tactile_maps.skin.fitting.cover import (
    COVER_LENGTHS,
    MAX_COVER_TAXELS,
    MIN_COVER_TAXELS,
    CoverCandidate,
    CoverSpec,
)
from tactile_maps.skin.taxel_placement.placement import MODULE_PITCH
from tactile_widgets.common.make import (
    add_items,
    caption_label,
    column_layout,
    make,
    push_button,
    row_layout,
    select_data,
    show_text,
)
from tactile_widgets.common.number_field import NumberField, guard_wheel
from tactile_widgets.common.panel import Panel
from tactile_widgets.panels.model.link_tree import LinkTree

_NUMBER = "number"
_PITCH = "pitch"
_AMOUNTS = (
    ("Number of taxels", _NUMBER, "Total number, shared out by area"),
    ("Distance of taxels", _PITCH, "Distance between neighbouring taxels"),
)
_PATTERNS = (
    ("Even", "even", "As evenly spaced as the surface allows"),
    ("Hexagonal", "hexagonal", "A lattice that follows the surface"),
    ("Modules of ten", "modules", "As many triangular modules as fit, as for iCub and CySkin"),
)
_AXES = (
    ("1: pressure", 1, "A taxel measures pressure"),
    ("3: pressure and shear", 3, "A taxel also measures shear in two directions; the first follows the map's x axis"),
)
_USUAL_PITCH = 10.0
"""Pitch that is offered first [mm]."""
_MM = 1e3
_MOST_REASONS = 2
"""Number of links without taxels whose reasons are written below the values; tool tips have all."""


@dataclass(frozen=True)
class SkinChoice:
    """A skin to begin with.

    Attributes:
        cover: Its cover; ``links`` are all links with skin.
        counts: Number of taxels of each link with skin; None until they are counted.
        bare: Reasons why links of the cover have no taxels.
        note: Text about where the taxels come from; may be empty.
        of: Name of the robot where it is not the one that is shown.
        apply: Text of the button that applies another choice.
        applicable: Whether the choice can be applied without a change.
    """

    cover: CoverSpec = field(default_factory=CoverSpec)
    counts: Mapping[str, int] | None = None
    bare: Mapping[str, str] = field(default_factory=dict)
    note: str = ""
    of: str = ""
    apply: str = "Apply"
    applicable: bool = False


class SkinPanel(Panel):
    """Links with check boxes, and the values of their cover."""

    needed = Signal()
    """The panel is shown, and its links have to be found."""
    edited = Signal()
    """The user changed a value; ``cover`` and ``different`` describe the choice."""
    apply_requested = Signal()
    """The user applies the choice."""
    reverted = Signal()
    """The user returns to the choice that was shown first."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Skin", "skin-panel", parent)
        self._shown = SkinChoice()
        self._refusal = ""
        self._failed = False
        self._needed = True
        self._empty = self.caption("Open a robot to choose the links that its skin covers.")
        self._content = content = QWidget(self)
        self.column.addWidget(content)
        self._closed = caption_label(content, "skin-refusal")
        self._of = caption_label(content, "skin-robot")
        self._of.hide()
        self.tree = LinkTree(content)
        self.tree.links_changed.connect(self._on_edited)
        self.tree.became_visible.connect(self._request_links)
        self._make_fields(content)
        self.note = caption_label(content, "skin-note")
        self.note.setMinimumWidth(1)
        tip = "Fit this skin and make its map; Undo brings the present one back"
        self.apply = push_button(content, "skin-apply", "Apply", tip, self.apply_requested)
        self.revert = push_button(content, "skin-revert", "Revert", "Show the present skin again", self._on_revert)
        named = (("Pattern", self.pattern), ("Margin to other links", self.margin), ("Axes", self.axes))
        rows = [row_layout(make(QLabel, name, content), None, control) for name, control in named]
        amount = row_layout(self.amount, None, self.taxels, self.pitch)
        self.bare = caption_label(content, "skin-bare")  # below the buttons, which must not move under the pointer
        self.bare.hide()
        buttons = row_layout(self.apply, self.revert, None)
        ends = (self.dense, self.note, buttons, self.bare)
        column_layout(self._of, self._closed, self.tree, amount, *rows, *ends, parent=content)
        self._closed.hide()
        content.hide()

    def _make_fields(self, content: QWidget) -> None:
        self.amount = make(QComboBox, content, objectName="skin-amount", accessibleName="Amount of taxels")
        add_items(self.amount, _AMOUNTS)
        tip = "Total number of taxels, shared out by area"
        self.taxels = NumberField("Number of taxels", "", MIN_COVER_TAXELS, MAX_COVER_TAXELS, 10, tip, content)
        low, high = (_MM * end for end in COVER_LENGTHS["pitch"])
        tip = "Distance between neighbouring taxels"
        self.pitch = NumberField("Distance of taxels", "mm", low, high, 0.5, tip, content)
        self.pattern = make(QComboBox, content, objectName="skin-pattern", accessibleName="Pattern")
        add_items(self.pattern, _PATTERNS)
        low, high = (_MM * end for end in COVER_LENGTHS["margin"])
        tip = "Distance of the skin from other links, so that joints can move"
        self.margin = NumberField("Margin to other links", "mm", low, high, 0.5, tip, content)
        self.axes = make(QComboBox, content, objectName="skin-axes", accessibleName="Axes")
        add_items(self.axes, _AXES)
        tip = "Place more taxels where the surface bends; only with the pattern Even"
        self.dense = make(
            QCheckBox, "More taxels where the surface bends", content, objectName="skin-dense", toolTip=tip
        )
        for box in (self.amount, self.pattern, self.axes):
            guard_wheel(box)
            box.activated.connect(self._on_edited)
        for name in ("taxels", "pitch", "margin"):
            number: NumberField = getattr(self, name)
            number.setObjectName(f"skin-{name}")
            number.valueChanged.connect(self._on_edited)
        self.dense.toggled.connect(self._on_edited)

    # What is shown.

    def show_choice(self, choice: SkinChoice, *, same_robot: bool = False) -> None:
        """Show a skin; its links are found again unless it is on the same robot."""
        self._shown = choice
        self._empty.hide()
        self._content.show()
        show_text(self._of, choice.of and f"Skin of {choice.of}, which is not open yet")
        self.apply.setText(choice.apply)
        if not same_robot:
            self._needed = True
            self.tree.show_candidates(())
        self._show_values()
        if self.tree.isVisible():
            self._request_links()

    def choose(self, cover: CoverSpec) -> None:
        """Show a choice that is not applied yet, as if the user made it."""
        self._show_cover(cover)
        self._on_edited()

    def show_nothing(self) -> None:
        """Show that no robot is open."""
        self._content.hide()
        self._empty.show()

    def _request_links(self) -> None:
        if self._needed:
            self._needed = False
            self.needed.emit()

    def show_candidates(self, candidates: Sequence[CoverCandidate]) -> None:
        """List the links of the robot, or only their areas if they are listed already."""
        if tuple(self.tree.rows) == tuple(candidate.link for candidate in candidates):
            self.tree.show_areas(candidates)
            return
        self.tree.show_candidates(candidates)
        self._show_values()

    def show_counts(self, counts: Mapping[str, int], bare: Mapping[str, str]) -> None:
        """Show the number of taxels of each link, for the current choice, and why links have none."""
        self._failed = False
        links = sum(count > 0 for count in counts.values())
        self.note.setText(f"{sum(counts.values()):,} taxels on {counted(links, 'link')}")
        self._show_taxels(counts, bare)
        self._update()

    def _show_taxels(self, counts: Mapping[str, int] | None, bare: Mapping[str, str]) -> None:
        """Show the numbers of taxels, None while they are being computed, and why links have none."""
        reasons = {link: bare[link] for link in self.links if link in bare and not (counts or {}).get(link)}
        self.tree.show_counts(counts, reasons)
        lines = [f"⚠ {link} {reason}" for link, reason in reasons.items()]
        if (more := len(lines) - _MOST_REASONS) > 0:
            them = "it for the reason" if more == 1 else "them for the reasons"
            lines[_MOST_REASONS:] = [f"⚠ {counted(more, 'more link')} without taxels: point at {them}"]
        show_text(self.bare, "\n".join(lines))

    def show_finding(self) -> None:
        """Show that the links of the robot are being found, and reserve the room of their list."""
        self.tree.reserve()
        self.show_progress("Finding the links")

    def show_progress(self, text: str) -> None:
        """Show what is being computed for the current choice."""
        self.note.setText(f"{text}…")

    def show_failure(self, text: str) -> None:
        """Show why the current choice is not possible."""
        self._failed = True
        self.note.setText(f"⚠ {text}")
        self._update()

    def show_refusal(self, reason: str) -> None:
        """Disable changes for a reason; an empty reason enables them."""
        self._refusal = reason
        self._closed.setText(reason)
        self._closed.setVisible(bool(reason))
        self._update()

    # The choice.

    @property
    def links(self) -> tuple[str, ...]:
        """Links with skin: those of the shown skin in their order, then others in the order of the robot."""
        checked = self.tree.checked if self.tree.rows else self._shown.cover.links
        kept = tuple(link for link in self._shown.cover.links if link in checked)
        return (*kept, *(link for link in checked if link not in kept))

    @property
    def cover(self) -> CoverSpec:
        """Cover as chosen; ``links`` are all links with skin."""
        shown = self._shown.cover
        pattern = self.pattern.currentData()
        pitch = self._length(self.pitch, shown.pitch) if self.amount.currentData() == _PITCH else None
        if pattern == "modules" and shown.pitch is None and pitch == MODULE_PITCH:
            pitch = None
        return replace(
            shown,
            links=self.links,
            taxels=round(self.taxels.value()),
            pitch=pitch,
            pattern=pattern,
            density="curvature" if self.dense.isChecked() and pattern == "even" else "uniform",
            margin=self._length(self.margin, shown.margin),
            axes=self.axes.currentData(),
        )

    @property
    def different(self) -> bool:
        """Whether the choice differs from the shown skin."""
        return self.cover != self._shown.cover

    @staticmethod
    def _length(number: NumberField, shown: float | None) -> float:
        """Return the number of a field [m]; the exact shown length if the field was not changed."""
        typed = number.value()
        if shown is not None and round(_MM * shown, number.decimals()) == typed:
            return shown
        return typed / _MM

    def _show_values(self) -> None:
        """Show the values of the shown skin."""
        self._failed = False
        self._show_cover(self._shown.cover)
        self._show_taxels(self._shown.counts, self._shown.bare)
        self.note.setText(self._shown.note)
        self._update()

    def _show_cover(self, cover: CoverSpec) -> None:
        self.tree.check(cover.links)
        modules = cover.pattern == "modules"
        select_data(self.amount, _NUMBER if cover.pitch is None and not modules else _PITCH)
        self.taxels.show_number(cover.taxels)
        usual = _MM * MODULE_PITCH if modules else _USUAL_PITCH
        self.pitch.show_number(usual if cover.pitch is None else _MM * cover.pitch)
        select_data(self.pattern, cover.pattern)
        self.margin.show_number(_MM * cover.margin)
        select_data(self.axes, cover.axes)
        with QSignalBlocker(self.dense):
            self.dense.setChecked(cover.density == "curvature")

    def _update(self) -> None:
        """Show and enable what the choice allows."""
        pattern = self.pattern.currentData()
        if pattern == "modules":
            select_data(self.amount, _PITCH)
        by_number = self.amount.currentData() == _NUMBER
        editable = not self._refusal
        self.taxels.setVisible(by_number)
        self.pitch.setVisible(not by_number)
        for control in (self.tree, self.taxels, self.pitch, self.pattern, self.margin, self.axes):
            control.setEnabled(editable)
        self.amount.setEnabled(editable and pattern != "modules")
        self.dense.setEnabled(editable and pattern == "even")
        changed = self.different
        self.apply.setEnabled(
            editable and bool(self.links) and not self._failed and (changed or self._shown.applicable)
        )
        self.revert.setEnabled(changed or self._shown.applicable)

    def _on_edited(self, *_changed: object) -> None:
        if self.pattern.currentData() == "modules" and self.amount.currentData() == _NUMBER:
            self.pitch.show_number(_MM * MODULE_PITCH)
        self._failed = False
        self._update()
        if not self.links:
            self._show_taxels({}, {})
            self.note.setText("Check at least one link.")
        elif self.different:
            self._show_taxels(None, {})
            self.note.setText("")
        else:
            self._show_values()
        self.edited.emit()

    def _on_revert(self) -> None:
        self._show_values()
        self.reverted.emit()

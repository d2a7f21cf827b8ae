"""Dialog for the export of a recording: format and range. Formats whose packages are missing cannot be chosen."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QSpinBox,
    QWidget,
)

from tactile_maps.export.export import FORMATS
from tactile_widgets.common.make import STYLE_SPACING, accept_buttons, column_layout, make, show_text
from tactile_widgets.dialogs.figures.span_fields import SpanFields

_MOST_FPS = 10_000
_LATE = 0.05
"""Session time of the first frame from which it is stated [s]; a session's first frame is at its first tick."""


class ExportDialog(QDialog):
    """Format, range and rows per second of an export.

    Args:
        duration: Duration of the recording [s].
        span: Selected range [s]; None if there is none.
        parent: The window.
        begins: Session time of the first frame [s].

    Attributes:
        formats: List of the formats.
        part: Fields of the range.
        fps: Rows per second, enabled for formats that have them; 0 for a row for each reading.
    """

    requested = Signal(str, object, object)
    """Name of the format; start and end [s], None for the whole recording; rows per second, None for all readings."""

    def __init__(
        self, duration: float, span: tuple[float, float] | None, parent: QWidget, *, begins: float = 0.0
    ) -> None:
        super().__init__(parent)
        self.setObjectName("export-dialog")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Export recording")
        self.formats = make(QListWidget, self, objectName="export-format", accessibleName="Format")
        self.part = SpanFields(duration, span, self)
        self.fps = make(QSpinBox, self, objectName="export-fps", accessibleName="Rows per second", maximum=_MOST_FPS)
        self.fps.setSpecialValueText("Every reading")
        self.fps.setToolTip("LeRobot: a lower rate than that of the readings adds a window of the readings of each row")
        self._begins = begins
        self._missing: dict[str, list[str]] = {}  # titles of formats by the command that installs their packages
        self._fill()
        self.note = make(QLabel, self, role="caption", wordWrap=True)
        self.note.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._copy = make(QPushButton, "Copy install command", self, objectName="copy-install", clicked=self._on_copy)
        self._copy.setVisible(bool(self._missing))
        buttons, self.export = accept_buttons(self, "Export…", self._on_accepted)
        buttons.addButton(self._copy, QDialogButtonBox.ButtonRole.ActionRole)
        form = QFormLayout()
        form.addRow("Format", self.formats)
        self.part.add_to(form)
        form.addRow("Rows per second", self.fps)
        column_layout(form, self.note, buttons, parent=self, spacing=STYLE_SPACING, margins=None)
        self.resize(520, 0)
        self.part.changed.connect(self._on_changed)
        self.formats.currentRowChanged.connect(self._on_changed)
        self._on_changed()

    def _fill(self) -> None:
        for form in FORMATS.values():
            item = QListWidgetItem(form.title, self.formats)
            item.setData(Qt.ItemDataRole.UserRole, form.name)
            if command := form.install:
                item.setFlags(Qt.ItemFlag.NoItemFlags)
                item.setText(f"{form.title} (not installed)")
                item.setToolTip(f"Install its packages, then start the program again:\n{command}")
                self._missing.setdefault(command, []).append(form.title)
        self.formats.setCurrentRow(0)
        self.formats.setMinimumHeight(self.formats.sizeHintForRow(0) * self.formats.count() + 8)
        self.formats.itemDoubleClicked.connect(self._on_accepted)

    def _on_changed(self) -> None:
        self.export.setEnabled(self.part.seconds >= 0)
        self.fps.setEnabled("fps" in FORMATS[self._format].uses)
        lines = [f"{', '.join(titles)}: {command}" for command, titles in self._missing.items()]
        if self.part.seconds < 0:
            lines = ["The end must not be before the beginning."]
        elif lines:
            lines.insert(0, "Formats that are not installed need one of these commands and a new start:")
        if self._begins >= _LATE:
            text = f"Tables and Rerun have the times of the session: the recording begins at {self._begins:.2f}\u202fs."
            lines.append(text)
        show_text(self.note, "\n".join(lines))

    def _on_copy(self) -> None:
        QGuiApplication.clipboard().setText("\n".join(self._missing))

    def _on_accepted(self, _item: object = None) -> None:
        span = None if self.part.whole else self.part.span
        fps = self.fps.value() if self.fps.isEnabled() else 0
        self.accept()
        self.requested.emit(self._format, span, fps or None)

    @property
    def _format(self) -> str:
        return str(self.formats.currentItem().data(Qt.ItemDataRole.UserRole))

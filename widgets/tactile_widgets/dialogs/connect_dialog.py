"""Dialog for the source of a real skin's readings, and the files that belong to it."""

from __future__ import annotations

import secrets
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QFormLayout,
    QLabel,
    QLineEdit,
    QSpinBox,
    QWidget,
)

from tactile_maps.live.channels.tare import LEAST_TARE
from tactile_maps.live.sources.open import DEFAULT_PORT, SourceOptions
from tactile_widgets.common.make import STYLE_SPACING, accept_buttons, make, push_button, row_layout
from tactile_widgets.common.number_field import guard_wheel
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.dialogs.dialogs import Dialogs
from tactile_widgets.session.live_input import LiveInputSettings

KINDS = {
    "UDP": f"udp://127.0.0.1:{DEFAULT_PORT}",
    "ZeroMQ": f"zmq://127.0.0.1:{DEFAULT_PORT}",
    "Serial port": "serial:///dev/ttyACM0?baud=115200",
    "YARP": "yarp://127.0.0.1:10000/skin/readings",
    "ROS 2": "ros2:",
    "File": "",
}
"""Kinds of sources with their initial addresses."""
_NO_TARE = LEAST_TARE - 1
"""Value of the field of the tare that stands for none; larger ones are numbers of readings."""
_FILTER = "Readings (*.csv *.txt *.parquet *.mcap *.db3)"


class ConnectDialog(QDialog):
    """Dialog for a source and its files; errors are shown in the dialog, which stays open.

    Args:
        dialogs: Asks for files.
        parent: The window.
    """

    connect_requested = Signal(LiveInputSettings)
    """Settings entered by the user."""

    def __init__(self, dialogs: Dialogs, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._dialogs = dialogs
        self.setObjectName("connect")
        self.setWindowTitle("Connect to a skin")
        self.setMinimumWidth(520)
        form = self._form = QFormLayout(self)
        self.kind = QComboBox(self)
        self.kind.addItems(list(KINDS))
        self.kind.currentTextChanged.connect(self._on_kind_changed)
        form.addRow("Source", self.kind)
        self._addresses = dict(KINDS)
        self.address, row = self._file_row("Choose the file…", _FILTER)
        self.address.textChanged.connect(self._on_address_changed)
        form.addRow("Address or file", row)
        form.addRow("Token", self._token_row())
        self.mapping, self._mapping_row = self._file_row("Choose the mapping of ROS messages…", "TOML (*.toml)")
        self._mapping_row.setObjectName("connect-mapping")
        self.mapping.setToolTip("Topics and fields of ROS 2 messages")
        self.mapping.setPlaceholderText("None")
        form.addRow("ROS mapping", self._mapping_row)
        self.ids, row = self._file_row("Choose the table of taxel IDs…", "CSV (*.csv)")
        self.ids.setPlaceholderText("As in the skin")
        form.addRow("Taxel IDs", row)
        self.calibration, row = self._file_row("Choose the calibration…", "Calibration (*.csv *.toml)")
        self.calibration.setPlaceholderText("None")
        form.addRow("Calibration", row)
        tip = "Number of readings at the start that are used as those of the untouched skin"
        self.tare = make(
            QSpinBox, self, minimum=_NO_TARE, maximum=10_000, specialValueText="None", suffix=" readings", toolTip=tip
        )
        form.addRow("Tare at start", self.tare)
        tip = "Use a negative gain; a calibration file states the signs of its gains itself"
        self.inverted = make(QCheckBox, "Values fall under pressure", self, toolTip=tip)
        form.addRow("Inverted", self.inverted)
        self.problem = make(QLabel, self, objectName="connect-problem", wordWrap=True)
        form.addRow(self.problem)
        buttons, self.go = accept_buttons(self, "Connect", self._on_accepted)
        form.addRow(buttons)
        guard_wheel(self)
        self._on_kind_changed(self.kind.currentText())
        self.say("")

    def show_source(self, kind: str, address: str) -> None:
        """Show a source; a kind that is unknown or empty changes nothing."""
        if kind in KINDS:
            self.kind.setCurrentText(kind)
            self.address.setText(address)

    def say(self, problem: str) -> None:
        """Show an error; an empty text hides the line."""
        self.problem.setText(as_sentence(problem))
        self.problem.setHidden(not problem)
        self._form.activate()
        self.resize(self.width(), self._form.totalHeightForWidth(self.width()))

    @property
    def settings(self) -> LiveInputSettings:
        """Settings as entered."""
        address = self.address.text().strip()
        options = SourceOptions(
            token=self.token.text() or None, remote=bool(self.token.text()), mapping=_path(self.mapping)
        )
        return LiveInputSettings(
            address,
            options,
            _path(self.ids),
            _path(self.calibration),
            None if self.tare.value() == _NO_TARE else self.tare.value(),
            inverted=self.inverted.isChecked(),
        )

    def _file_row(self, title: str, kinds: str) -> tuple[QLineEdit, QWidget]:
        row = QWidget(self)
        edit = QLineEdit(row)

        def choose() -> None:
            path = self._dialogs.open_file(title, kinds, over=self)
            if path:
                edit.setText(path)

        button = push_button(row, "", "…", title, choose, accessibleName=title, autoDefault=False, maximumWidth=32)
        row_layout(edit, button, parent=row, spacing=STYLE_SPACING)
        return edit, row

    def _token_row(self) -> QWidget:
        row = QWidget(self)
        use = "required for readings from other computers and to move a robot"
        tip = f"Every packet must contain it; {use}. At least 8 characters."
        self.token = make(QLineEdit, row, placeholderText="None", toolTip=tip)
        tip = "Generate a token and copy it to the clipboard; set the same token in the sender"
        self.make_token = push_button(row, "", "Generate", tip, self._on_make_token_clicked, autoDefault=False)
        row_layout(self.token, self.make_token, parent=row, spacing=STYLE_SPACING)
        return row

    def _on_make_token_clicked(self) -> None:
        self.token.setText(secrets.token_urlsafe(12))
        self.token.selectAll()
        self.token.copy()

    def _on_kind_changed(self, kind: str) -> None:
        self.address.setText(self._addresses[kind])
        self._mapping_row.setEnabled(kind in ("ROS 2", "File"))
        self.say("")

    def _on_address_changed(self, address: str) -> None:
        self._addresses[self.kind.currentText()] = address

    def _on_accepted(self) -> None:
        self.connect_requested.emit(self.settings)


def _path(edit: QLineEdit) -> Path | None:
    text = edit.text().strip()
    return Path(text) if text else None

"""Everything that asks a person in a window of its own: files, questions, and short texts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox, QWidget

Button = QMessageBox.StandardButton


class Dialogs:
    """Asks over ``parent``.

    Args:
        parent: The window.
    """

    def __init__(self, parent: QWidget) -> None:
        self._parent = parent
        self._shown: dict[str, QMessageBox] = {}

    def open_file(self, title: str, kinds: str) -> str:
        """Ask for a file to read; empty when none is chosen."""
        return QFileDialog.getOpenFileName(self._parent, title, "", f"{kinds};;All files (*)")[0]

    def open_folder(self, title: str) -> str:
        """Ask for a folder; empty when none is chosen."""
        return QFileDialog.getExistingDirectory(self._parent, title)

    def save_file(self, title: str, name: str, kinds: str) -> str:
        """Ask for a file to write, by default called ``name``; empty when none is chosen."""
        return QFileDialog.getSaveFileName(self._parent, title, name, kinds)[0]

    def ask(
        self, name: str, title: str, text: str, buttons: Button, then: Callable[[Button], None], *, default: Button
    ) -> None:
        """Ask a question; ``then`` is called with the button that was pressed."""
        box = self._show(name, title, text, buttons)
        box.setDefaultButton(default)
        box.finished.connect(lambda answer: then(Button(answer)))

    def ask_text(self, name: str, title: str, text: str, then: Callable[[str], None]) -> None:
        """Ask for a line; ``then`` is called with it unless it is cancelled."""
        box = QInputDialog(self._parent)
        box.setObjectName(name)
        box.setWindowTitle(title)
        box.setLabelText(text)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.textValueSelected.connect(then)
        box.open()

    def ask_choice(self, name: str, title: str, text: str, choices: Sequence[str], then: Callable[[str], None]) -> None:
        """Ask for one of ``choices``; ``then`` is called with it unless it is cancelled."""
        box = QInputDialog(self._parent)
        box.setObjectName(name)
        box.setWindowTitle(title)
        box.setLabelText(text)
        box.setComboBoxItems(list(choices))
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.textValueSelected.connect(then)
        box.open()

    def tell(self, name: str, title: str, text: str) -> None:
        """Show a text with a button that closes it; asked for again while it is open, it comes to the front."""
        if name in self._shown:
            self._shown[name].activateWindow()
        else:
            self._shown[name] = self._show(name, title, text, Button.Close)
            self._shown[name].finished.connect(lambda _answer: self._shown.pop(name, None))

    def _show(self, name: str, title: str, text: str, buttons: Button) -> QMessageBox:
        box = QMessageBox(QMessageBox.Icon.NoIcon, title, text, buttons, self._parent)
        box.setObjectName(name)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.open()
        return box

"""Tables of studies: opened by a dialog or a drop, those that ship by the Help menu, each in a window of its own."""

from __future__ import annotations

from functools import partial

from PySide6.QtWidgets import QMenu, QWidget

from app.core.errors import TactileMapsError
from app.studies.running.study_table import read_study_table
from assets import asset
from widgets.common.file_types import STUDY_FILTER
from widgets.context.app_context import AppContext
from widgets.context.study_dialog import StudyDialog


class StudyPresenter:
    """Opens tables of studies.

    Args:
        context: What it works on.
        parent: Over which windows open.
    """

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        self._context, self._window = context, parent
        context.actions.bind("open_study", self.choose)

    def choose(self) -> None:
        """Ask for a table."""
        path = self._context.dialogs.open_file("Open study table", STUDY_FILTER)
        if path:
            self.open(path)

    def open(self, path: str) -> None:
        """Show a table in a window of its own; say why where it is none."""
        try:
            table = read_study_table(path)
        except TactileMapsError as error:
            self._context.notifier.fault(str(error))
            return
        dialog = StudyDialog(table, self._context.theme.theme, self._window)
        self._context.theme.changed.connect(dialog.set_theme)
        dialog.show()

    def list_findings(self, menu: QMenu) -> None:
        """List the tables that ship."""
        if menu.isEmpty():
            for path in sorted(asset("findings").glob("*.csv")):
                item = menu.addAction(path.stem.replace("-", " ").capitalize())
                item.setObjectName(f"finding-{path.stem}")
                item.setToolTip(f"What tactile-maps study {path.stem} measured")
                item.triggered.connect(partial(self._open_listed, str(path)))

    def _open_listed(self, path: str, _checked: bool = False) -> None:
        self.open(path)

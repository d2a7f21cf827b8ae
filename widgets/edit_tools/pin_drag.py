"""One pin under the hand: its patch follows at every move, and between them until it has come to rest."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, QTimer

from app.arrays import FloatArray
from app.editing.document import MapDocument
from app.editing.pins import chart_place, grip, hold
from app.errors import MapError
from app.maps.pins import PinnedPatch
from widgets.editor import Editor

FRAME_MS = 16


class PinDrag(QObject):
    """A gesture of the editor that drags one pin. Mutable; over after ``end`` or ``cancel``, or when undone.

    Args:
        editor: A gesture is going on in it.
        document: As it was before the gesture, with the pin if that is new.
        number: Of the patch.
        pin: Of its pins, by number.
        grab: (2,) from the pin to the hand on the map [m].
        parent: Qt parent.

    Raises:
        MapError: The patch cannot be followed by hand.

    Cost: 30 ms for 10,000 faces; a move 8 to 18 ms.
    """

    def __init__(
        self, editor: Editor, document: MapDocument, number: int, pin: int, grab: FloatArray, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._editor, self._document, self._pin, self._grab = editor, document, pin, grab
        self.number = number
        self._gripped: PinnedPatch = grip(document, number)
        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(FRAME_MS)
        self._rest.timeout.connect(self._on_rest)

    def move(self, point: FloatArray) -> None:
        """The hand is at a map point (2,) [m]."""
        try:
            self._gripped.move(self._pin, chart_place(self._document, self.number, point - self._grab))
        except MapError:
            return  # a hundred maps away: the pin waits where the hand was last near enough to be seen
        self._follow()

    def end(self) -> None:
        """The hand let go: the gesture is one step."""
        self._rest.stop()
        self._editor.end()

    def cancel(self) -> None:
        """The gesture never was."""
        self._rest.stop()
        self._editor.cancel()

    def drop(self) -> None:
        """The gesture was ended by somebody else."""
        self._rest.stop()

    def _follow(self) -> None:
        self._gripped.frame()
        edit: Callable[[MapDocument], MapDocument] = partial(hold, number=self.number, gripped=self._gripped)
        if self._editor.change(edit) and not self._gripped.still:
            self._rest.start()

    def _on_rest(self) -> None:
        """The hand rests and the patch does not yet."""
        if self._editor.gesture:
            self._follow()

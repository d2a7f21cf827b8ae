"""A process for slow work: preparing scenes, and laying patches flat anew. So the window never waits."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject, Signal

from app.core.errors import TactileMapsError
from app.editing.reflatten import ReflattenRequest, ReflattenResult, reflatten
from app.scene.scene import Scene
from app.session.prepare import PreparedScene, prepare
from widgets.workers.worker_process import Reply, RequestHandler, WorkerProcess

_DIED_PREPARING = (
    "Preparing the scene ended unexpectedly; the scene before it is kept. Try fewer taxels, or another link."
)
_DIED_EDITING = "The edit ended unexpectedly; the map before it is kept. Try another method, or fewer seams."


def make_handler() -> RequestHandler:
    """In the process: scenes and edits in; progress, what was made, or a failure, out."""

    def serve(request: object, tell: Reply) -> None:
        def progress(text: str, done: float) -> None:
            tell("progress", (text, done))

        if isinstance(request, Scene):
            tell("prepared", prepare(request, progress=progress))
        elif isinstance(request, ReflattenRequest):
            tell("reflattened", reflatten(request, progress=progress))

    return serve


class SceneWorker(QObject):
    """Does one thing at a time; the newest request wins, a scene before an edit. ``close`` ends the process."""

    progressed = Signal(str, float)
    """What is being done for a scene, and how far it is, 0 to 1."""
    prepared = Signal(object)
    """A Prepared."""
    failed = Signal(str)
    """Why there is none."""
    edit_progressed = Signal(str, float)
    """What is being done for an edit, and how far it is."""
    reflattened = Signal(object)
    """A ReflattenResult."""
    edit_failed = Signal(str)
    """Why there is none; empty where a scene took its place."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("prepare", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)
        self._doing: type[Scene | ReflattenRequest] | None = None

    @property
    def busy(self) -> bool:
        """Whether a scene is being prepared."""
        return self._doing is Scene

    @property
    def editing(self) -> bool:
        """Whether a patch is being laid flat."""
        return self._doing is ReflattenRequest

    def warm(self) -> None:
        """Start the process now, so that the next request need not wait for it."""
        self.process.warm()

    def prepare(self, scene: Scene) -> None:
        """Prepare ``scene``, and drop whatever is being done."""
        dropped = self.editing
        self._request(scene)
        if dropped:
            self.edit_failed.emit("")

    def reflatten(self, request: ReflattenRequest) -> None:
        """Lay patches flat anew, instead of what was asked for before; not while a scene is being prepared."""
        if self.busy:
            self.edit_failed.emit("A scene is being opened; edit its map when it is there.")
        else:
            self._request(request)

    def _request(self, content: Scene | ReflattenRequest) -> None:
        if self.process.waiting:
            self.process.close()
        self._doing = type(content)
        self.process.send(content)

    def cancel(self) -> None:
        """Drop the scene being prepared, and be ready for the next request."""
        if self.busy:
            self._drop()

    def cancel_edit(self) -> None:
        """Drop the edit being computed."""
        if self.editing:
            self._drop()

    def close(self) -> None:
        """End the process, whatever it does."""
        self._doing = None
        self.process.close()

    def _drop(self) -> None:
        self.close()
        self.warm()

    def _on_answered(self, kind: str, content: Any) -> None:
        editing = self.editing
        if kind == "progress":
            (self.edit_progressed if editing else self.progressed).emit(*content)
            return
        if kind == "done":
            return
        self._doing = None
        if kind == "failed":
            (self.edit_failed if editing else self.failed).emit(content)
        elif isinstance(content, ReflattenResult):
            self.reflattened.emit(content)
        elif isinstance(content, PreparedScene):
            self.prepared.emit(content)

    def _on_ended(self) -> None:
        """The process died: killed, out of memory, or a native library crashed in it."""
        editing = self.editing
        self.close()
        (self.edit_failed if editing else self.failed).emit(_DIED_EDITING if editing else _DIED_PREPARING)


class InlineSceneWorker(SceneWorker):
    """Works at once, while the caller waits: deterministic, for tests and pictures."""

    def warm(self) -> None:
        """There is no process to start."""

    def _request(self, content: Scene | ReflattenRequest) -> None:
        self._doing = type(content)
        try:
            make_handler()(content, self._on_answered)
        except TactileMapsError as error:
            self._on_answered("failed", str(error))

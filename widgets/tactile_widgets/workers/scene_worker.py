"""A process for slow work: opening scenes and recordings, laying patches flat anew. So the window never waits.

When it has nothing else to do it makes the coarser links that the robot view draws without a graphics card.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.core.progress import Progress
from tactile_maps.editing.reflatten import ReflattenRequest, ReflattenResult, reflatten
from tactile_maps.maps.image_atlas import ImageAtlas, ImageSettings
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.scene import Scene
from tactile_maps.session.link_levels import LinkLevels
from tactile_maps.session.prepare import PreparedScene, open_scene
from tactile_maps.session.prepared_cache import link_levels_cached, load_robot_cached, prepare_cached
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

_DIED_PREPARING = (
    "Preparing the scene ended unexpectedly; the scene before it is kept. Try fewer taxels, or another link."
)
_DIED_READING = "Reading the recording ended unexpectedly; what was shown before is kept. It may need more memory."
_DIED_EDITING = "The edit ended unexpectedly; the map before it is kept. Try another method, or fewer seams."
_GAVE_WAY = "The edit being computed was dropped, because a recording is opened. Ask for it again afterwards."


@dataclass(frozen=True)
class OpenScene:
    """Read a scene's file, check what it names, and prepare it."""

    path: Path
    package_roots: tuple[str, ...] = ()


@dataclass(frozen=True)
class OpenRecording:
    """Read a recording's file."""

    path: Path


@dataclass(frozen=True, eq=False)
class _MakeLevels:
    """Make the coarser surfaces of a robot's links."""

    robot: Robot


Opening = Scene | OpenScene | OpenRecording
Task = Opening | ReflattenRequest


@dataclass(frozen=True)
class _OpenWithImage:
    """Open a scene or a recording, and make the live image of its map."""

    opening: Opening
    image: ImageSettings


@dataclass(frozen=True, eq=False)
class _Opened:
    """What was opened, and its live image, of the very same charts; None where whoever shows it makes it."""

    content: PreparedScene | RecordingPlayer
    image: ImageAtlas | None


_OPENING = SourceToken("opening")
"""Of a scene or a recording: what is opened is shown whatever was shown before."""


def make_handler() -> RequestHandler:
    """In the process: scenes, recordings and edits in; progress, what was made, or a failure, out."""

    def serve(request: object, tell: Reply) -> None:
        def progress(text: str, done: float) -> None:
            tell("progress", (text, done))

        if isinstance(request, _OpenWithImage):
            content = _open(request.opening, progress)
            shown = content.prepared if isinstance(content, RecordingPlayer) else content
            tell("opened", _Opened(content, ImageAtlas(shown.map, look=request.image)))
        elif isinstance(request, Opening):
            tell("opened", _Opened(_open(request, progress), None))
        elif isinstance(request, ReflattenRequest):
            tell("reflattened", reflatten(request, progress=progress))
        elif isinstance(request, _MakeLevels):
            tell("levels", link_levels_cached(request.robot))

    return serve


def _open(opening: Opening, progress: Progress) -> PreparedScene | RecordingPlayer:
    if isinstance(opening, OpenRecording):
        return RecordingPlayer(opening.path, progress=progress)
    if isinstance(opening, OpenScene):
        opening = open_scene(str(opening.path), package_roots=opening.package_roots, load=load_robot_cached)
    return prepare_cached(opening, progress=progress)


class SceneWorker(QObject):
    """Does one thing at a time; the newest request wins, a scene or recording before an edit.

    ``close`` ends the process.

    Attributes:
        image: How the live image of what is opened is to be made.
    """

    progressed = Signal(str, float)
    """What is being done for a scene or a recording, and how far it is, 0 to 1."""
    image_made = Signal(object)
    """The ImageAtlas of the scene or recording that comes next."""
    prepared = Signal(object)
    """A PreparedScene."""
    opened = Signal(object)
    """A RecordingPlayer."""
    failed = Signal(str)
    """Why there is neither."""
    edit_progressed = Signal(str, float)
    """What is being done for an edit, and how far it is."""
    reflattened = Signal(object)
    """The Result with a ReflattenResult."""
    edit_failed = Signal(object)
    """The Result with why there is none; with nothing where a scene took its place."""
    levels_made = Signal(object)
    """The LinkLevels of the robot asked for last."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("prepare", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)
        self.image = ImageSettings()
        self._task: Task | None = None
        self._token = _OPENING
        self._detail: _MakeLevels | None = None
        self._detail_number = 0

    @property
    def busy(self) -> bool:
        """Whether a scene or a recording is being opened."""
        return isinstance(self._task, Opening)

    @property
    def editing(self) -> bool:
        """Whether a patch is being flattened."""
        return isinstance(self._task, ReflattenRequest)

    def warm(self) -> None:
        """Start the process now, so that the next request need not wait for it."""
        self.process.warm()

    def prepare(self, scene: Scene | OpenScene) -> None:
        """Prepare a scene, and drop whatever is being done."""
        self._instead_of_an_edit(scene, "")

    def open_recording(self, path: Path) -> None:
        """Read a recording, and drop whatever is being done. Cost: 20 ms for each second recorded, beside."""
        self._instead_of_an_edit(OpenRecording(path), _GAVE_WAY)

    def reflatten(self, request: ReflattenRequest, token: SourceToken) -> None:
        """Lay patches flat anew, instead of what was asked for before; not while something is being opened."""
        if self.busy:
            text = "A scene or a recording is being opened; edit the map when it is there."
            self.edit_failed.emit(Result(token, text))
        else:
            self._request(request, token)

    def make_levels(self, robot: Robot) -> None:
        """Make the coarser links of ``robot`` once nothing else is to be done; whatever is asked for goes before it."""
        if self._detail is not None:
            if self._detail.robot.links is robot.links:
                return
            if self._task is None:
                self.process.close()  # whatever it makes is of another robot
        self._detail = _MakeLevels(replace(robot, mjcf="", assets={}))
        self._send_detail()

    def _send_detail(self) -> None:
        if self._detail is not None:
            self._detail_number = self.process.send(self._detail, _OPENING)

    def _instead_of_an_edit(self, task: Task, dropped: str) -> None:
        editing = self.editing
        token = self._token
        self._request(task, _OPENING)
        if editing:
            self.edit_failed.emit(Result(token, dropped))

    def _request(self, task: Task, token: SourceToken) -> None:
        if self.process.waiting:
            self.process.close()
        self._task = task
        self._token = token
        self.process.send(_OpenWithImage(task, self.image) if isinstance(task, Opening) else task, token)
        if self.editing:  # what is opened has links of its own
            self._send_detail()

    def drop(self) -> None:
        """Drop whatever is being done: a scene that needs no worker takes its place."""
        editing = self.editing
        token = self._token
        if self._task is not None:
            self._drop()
        if editing:
            self.edit_failed.emit(Result(token, ""))

    def cancel(self) -> None:
        """Drop what is being opened, and be ready for the next request."""
        if self.busy:
            self._drop()

    def cancel_edit(self) -> None:
        """Drop the edit being computed."""
        if self.editing:
            self._drop()

    def close(self) -> None:
        """End the process, whatever it does."""
        self._task = self._detail = None
        self.process.close()

    def _drop(self) -> None:
        self._task = None
        self.process.close()
        self.warm()
        self._send_detail()

    def _on_answered(self, number: int, kind: str, result: Result[Any]) -> None:
        """Of one task only: another ends the process before it is sent; or of the links that are made after it."""
        editing = self.editing
        content = result.value
        if number == self._detail_number and number:
            self._detail = None  # made, or not to be had: links are drawn as they are
            if isinstance(content, LinkLevels):
                self.levels_made.emit(content)
            return
        if kind == "progress":
            (self.edit_progressed if editing else self.progressed).emit(*content)
            return
        if kind == "done":
            return
        self._task = None
        if kind == "failed":
            self.edit_failed.emit(result) if editing else self.failed.emit(content)
        elif isinstance(content, ReflattenResult):
            self.reflattened.emit(result)
        elif isinstance(content, _Opened):
            self._detail = None
            if content.image is not None:
                self.image_made.emit(content.image)
            shown = content.content
            (self.prepared if isinstance(shown, PreparedScene) else self.opened).emit(shown)

    def _on_ended(self, token: SourceToken) -> None:
        """The process died: killed, out of memory, or a native library crashed in it."""
        task = self._task
        self.close()
        if task is None:
            return  # links are drawn as they are
        if isinstance(task, ReflattenRequest):
            self.edit_failed.emit(Result(token, _DIED_EDITING))
        else:
            self.failed.emit(_DIED_READING if isinstance(task, OpenRecording) else _DIED_PREPARING)


class InlineSceneWorker(SceneWorker):
    """Works at once, while the caller waits: deterministic, for tests and pictures."""

    def warm(self) -> None:
        """There is no process to start."""

    def make_levels(self, robot: Robot) -> None:
        """Links are drawn as they are: nothing is beside to make others."""

    def _request(self, task: Task, token: SourceToken) -> None:
        self._task = task
        self._token = token

        def tell(kind: str, content: object) -> None:
            self._on_answered(0, kind, Result(token, content))

        try:
            make_handler()(task, tell)
        except TactileMapsError as error:
            tell("failed", str(error))

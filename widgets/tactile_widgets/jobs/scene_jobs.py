"""Opening of scenes and recordings, and edits of the map, in one process; only the newest request counts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.progress import Progress
from tactile_maps.editing.reflatten import ReflattenRequest, ReflattenResult, reflatten
from tactile_maps.maps.image_atlas import ImageAtlas, ImageSettings
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.scene import Scene
from tactile_maps.session.link_levels import LinkLevels
from tactile_maps.session.prepare import PreparedScene, check_stimuli, open_scene
from tactile_maps.session.prepared_cache import link_levels_cached, load_robot_cached, prepare_cached
from tactile_widgets.jobs.executor import Executor, Job, Report, Running
from tactile_widgets.jobs.skin_jobs import plan_cover

_DIED_PREPARING = (
    "Preparing the scene ended unexpectedly; the scene before it is kept. Try fewer taxels, or another link."
)
_DIED_READING = "Reading the recording ended unexpectedly; what was shown before is kept. It may need more memory."
_DIED_EDITING = "The edit ended unexpectedly; the map before it is kept. Try another method, or fewer seams."
_DROPPED = "The edit being computed was dropped, because a recording is opened. Repeat it afterwards."
_OPENING = "A scene or a recording is being opened; edit the map once it is open."


@dataclass(frozen=True)
class SceneFile:
    """A scene's file, and the folders of its packages."""

    path: Path
    package_roots: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Opened:
    """Content that was opened, and the tactile image of its map; None if the view makes the image."""

    content: PreparedScene | RecordingPlayer
    image: ImageAtlas | None


def open_content(opening: Scene | SceneFile | Path, look: ImageSettings | None, report: Report) -> Opened:
    """Prepare a scene, or read the recording at a path, and make its tactile image unless ``look`` is None."""
    if isinstance(opening, Path):
        player = RecordingPlayer(opening, progress=report)
        return Opened(player, None if look is None else ImageAtlas(player.prepared.map, look=look))
    file = opening if isinstance(opening, SceneFile) else None
    if isinstance(opening, SceneFile):
        opening = open_scene(str(opening.path), package_roots=opening.package_roots, load=load_robot_cached)
    prepared = prepare_cached(opening, progress=report, loaded=partial(_report_plan, opening, report))
    if file is not None:
        check_stimuli(prepared, str(file.path))
    return Opened(prepared, None if look is None else ImageAtlas(prepared.map, look=look))


def _report_plan(scene: Scene, report: Report, robot: Robot) -> None:
    """Send the plan of the scene's cover, if it has one."""
    if not scene.taxel_files and (scene.cover.links or not scene.grids):
        report.part(plan_cover(scene, robot))


def reflatten_patches(request: ReflattenRequest, report: Report) -> ReflattenResult:
    """Flatten patches again."""
    return reflatten(request, progress=report)


def make_link_levels(robot: Robot, _report: Report) -> LinkLevels:
    """Make the coarser links that the robot view draws without a graphics card."""
    return link_levels_cached(robot)


class SceneJobs(QObject):
    """Runs one request at a time; the newest one replaces the others, and opening has precedence over editing.

    Args:
        executor: Runs the jobs.
        parent: Qt parent.

    Attributes:
        executor: The executor.
        image: Settings of the tactile image of what is opened.
    """

    progressed = Signal(str, float)
    """Progress of opening: what is being done, and its share, 0 to 1."""
    planned = Signal(object)
    """CoverPlan of a scene, before its skin is fitted."""
    image_made = Signal(object)
    """ImageAtlas of the content that follows."""
    prepared = Signal(object)
    """A PreparedScene."""
    opened = Signal(object)
    """A RecordingPlayer."""
    failed = Signal(str)
    """Reason why nothing could be opened."""
    levels_made = Signal(object)
    """LinkLevels of the robot requested last."""

    def __init__(self, executor: Executor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        executor.setParent(self)
        self.executor = executor
        self.image = ImageSettings()
        self._opening: Running[Any] | None = None
        self._edit: Running[Any] | None = None
        self._edit_failed: Callable[[str], None] | None = None
        self._levels: Running[Any] | None = None
        self._robot: Robot | None = None  # whose links are still to be made

    @property
    def busy(self) -> bool:
        """Whether a scene or a recording is being opened."""
        return self._opening is not None and not self._opening.done

    @property
    def editing(self) -> bool:
        """Whether an edit is being computed."""
        return self._edit is not None and not self._edit.done

    def warm(self) -> None:
        """Start the process, so that the next request does not wait for it."""
        self.executor.warm(open_content)

    def prepare(self, scene: Scene | SceneFile) -> None:
        """Prepare a scene; cancels everything else."""
        self._open(scene, _DIED_PREPARING, "")

    def open_recording(self, path: Path) -> None:
        """Read a recording; cancels everything else. Cost: 20 ms for each recorded second."""
        self._open(path, _DIED_READING, _DROPPED)

    def reflatten(
        self,
        request: ReflattenRequest,
        finished: Callable[[ReflattenResult], None],
        failed: Callable[[str], None],
        progressed: Progress,
    ) -> None:
        """Flatten patches again, instead of the previous edit; it fails while something is being opened.

        Args:
            request: The patches.
            finished: Receives the result.
            failed: Receives the reason for the failure; empty if a scene replaces the edit.
            progressed: Receives the progress.
        """
        if self.busy:
            failed(_OPENING)
            return
        self._end_jobs()
        self._edit_failed = failed
        job = Job(reflatten_patches, request, died=_DIED_EDITING)
        self._edit = self.executor.start(job, finished, failed, progressed=progressed)
        self._start_levels()

    def make_levels(self, robot: Robot) -> None:
        """Make the coarser links of ``robot`` in a process, after everything else."""
        if not self.executor.background:
            return
        if self._robot is not None and self._levels is not None:
            if self._robot.links is robot.links:
                return
            self._levels.cancel()
        self._robot = replace(robot, mjcf="", assets={})
        self._start_levels()

    def drop(self) -> None:
        """End opening and editing: a scene that is already prepared is shown instead."""
        editing = self.editing
        if self.busy or editing:
            self._restart()
        if editing and self._edit_failed is not None:
            self._edit_failed("")

    def cancel(self) -> None:
        """End opening, and be ready for the next request."""
        if self.busy:
            self._restart()

    def cancel_edit(self) -> None:
        """End the edit being computed."""
        if self.editing:
            self._restart()

    def close(self) -> None:
        """End the process."""
        self._robot = None
        self.executor.close()

    def _open(self, opening: Scene | SceneFile | Path, died: str, dropped: str) -> None:
        editing = self.editing
        self._end_jobs()
        look = self.image if self.executor.background else None
        job = Job(open_content, opening, look, died=died)
        self._opening = self.executor.start(
            job, self._on_opened, self.failed.emit, progressed=self.progressed.emit, received=self.planned.emit
        )
        if editing and self._edit_failed is not None:
            self._edit_failed(dropped)

    def _end_jobs(self) -> None:
        if self.executor.busy:
            self.executor.close()

    def _restart(self) -> None:
        self.executor.close()
        self.warm()
        self._start_levels()

    def _start_levels(self) -> None:
        if self._robot is not None:
            job = Job(make_link_levels, self._robot, died="")
            self._levels = self.executor.start(job, self._on_levels, self._on_no_levels)

    def _on_opened(self, opened: Opened) -> None:
        self._robot = None  # the content has other links
        if opened.image is not None:
            self.image_made.emit(opened.image)
        content = opened.content
        (self.prepared if isinstance(content, PreparedScene) else self.opened).emit(content)

    def _on_levels(self, levels: LinkLevels) -> None:
        self._robot = None
        self.levels_made.emit(levels)

    def _on_no_levels(self, _reason: str) -> None:
        self._robot = None  # the full links are drawn

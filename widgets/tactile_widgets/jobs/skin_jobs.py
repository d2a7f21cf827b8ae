"""Links that can be covered, and skins that are being chosen: found and fitted in a separate process."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import fit_skin
from tactile_maps.session.prepared_cache import load_robot_cached
from tactile_maps.skin.fitting.cover import CoverCandidate, choose_links, cover_candidates
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.jobs.executor import Executor, Job, Kept, Report, Running, keep

SETTLE_MS = 250
"""Time after the last change of a value until the skin is fitted [ms]."""
_QUICK_TAXELS = 2000
"""Number of taxels up to which fitting them to the end takes less time than starting another process."""
_DIED = "Fitting the preview ended unexpectedly. Try fewer taxels, or another link."


@dataclass(frozen=True)
class CoverPlan:
    """Skin that a robot will get, known before it is fitted.

    Attributes:
        scene: The scene that is being opened.
        links: Links that will be covered.
        taxels: Number of taxels on all of them; None if it follows from the pitch.
    """

    scene: Scene
    links: tuple[str, ...]
    taxels: int | None


def plan_cover(scene: Scene, robot: Robot) -> CoverPlan:
    """Return the links that the cover of a scene will be on. Cost: 1 ms a link if the scene names none."""
    taxels = scene.cover.taxels if scene.cover.taxel_area is None else None
    return CoverPlan(scene, scene.cover.links or choose_links(robot), taxels)


def find_candidates(robot: Kept[Robot], _report: Report) -> tuple[CoverCandidate, ...]:
    """Return all links of a robot."""
    return cover_candidates(robot.value)


def fit_preview(robot: Kept[Robot], scene: Scene, report: Report) -> Skin:
    """Return the skin of a scene on its robot. Cost: about 1 s for 1000 taxels on three links."""
    return fit_skin(scene, robot.value, progress=report)


class SkinPreview(QObject):
    """Fits the skin of a scene on one robot, which is sent to the process once.

    Args:
        executor: Fits the skins.
        parent: Qt parent.

    Attributes:
        executor: The executor.
    """

    found = Signal(object)
    """Tuple of CoverCandidate: the links of the robot."""
    progressed = Signal(str, float)
    """Stage of fitting, and the share done, 0 to 1."""
    fitted = Signal(object)
    """Skin of the scene requested last."""
    failed = Signal(str)
    """Reason why that skin cannot be fitted, or the links cannot be found."""

    def __init__(self, executor: Executor, parent: QObject) -> None:
        super().__init__(parent)
        executor.setParent(self)
        self.executor = executor
        self._robot: Kept[Robot] | None = None
        self._running: Running[Any] | None = None
        self._scene: Scene | None = None
        self._settling = QTimer(self)
        self._settling.setSingleShot(True)
        self._settling.setInterval(SETTLE_MS)
        self._settling.timeout.connect(self._fit)

    def show_robot(self, robot: Robot) -> None:
        """Preview skins of this robot from now on, and find its links."""
        self._begin(keep(robot))

    def show_robot_of(self, scene: Scene) -> None:
        """Preview skins of the robot of a scene, which the process loads, and find its links."""
        self._begin(Kept(partial(load_robot_cached, scene)))

    def _begin(self, robot: Kept[Robot]) -> None:
        self.close()
        self._robot = robot
        self.executor.start(Job(find_candidates, robot, died=_DIED), self.found.emit, self.failed.emit)

    def request(self, scene: Scene) -> None:
        """Fit the skin of a scene once no other request follows for a moment; earlier requests are cancelled."""
        self.cancel()
        self._scene = scene
        self._settling.start()

    def cancel(self) -> None:
        """Cancel what was requested."""
        self._settling.stop()
        if self._running is not None and self._scene is not None:
            cover = self._scene.cover
            quick = cover.taxel_area is None and cover.taxels <= _QUICK_TAXELS
            (self._running.ignore if quick else self._running.cancel)()
            self._running = None

    def close(self) -> None:
        """End the process."""
        self.cancel()
        self.executor.close()
        self._robot = None

    def _fit(self) -> None:
        if self._robot is not None and self._scene is not None:
            job = Job(fit_preview, self._robot, self._scene, died=_DIED)
            self._running = self.executor.start(
                job, self.fitted.emit, self.failed.emit, progressed=self.progressed.emit
            )

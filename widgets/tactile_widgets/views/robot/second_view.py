"""Additional views of the robot: one with its own camera, and a small one that follows the contact.

They draw a few times per second, so that the main view stays responsive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, QSize, QTimer, Signal
from PySide6.QtGui import QMouseEvent, QResizeEvent, QShowEvent, QWheelEvent
from PySide6.QtWidgets import QFrame, QLabel, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import column_layout, make
from tactile_widgets.common.settings import NavigationStyle
from tactile_widgets.views.interaction.navigation import CameraMotion, motion_of
from tactile_widgets.views.robot.actors.camera import Viewpoint, look_from, zoom
from tactile_widgets.views.robot.actors.contact_marks import ring_radius
from tactile_widgets.views.robot.actors.robot_actors import BodyLayerFactory
from tactile_widgets.views.robot.robot_display import RobotDisplay

EVERY_MS = 100
"""Interval between two frames that are shown."""
_WHEEL_STEP = 1.15
_OTHER_SIDE = np.radians(100.0)
"""Angle from the direction of the robot view, about the vertical [rad]."""


class SecondView(QWidget):
    """View of the robot without tools: left or right drag turns, middle button or Shift pans, wheel zooms.

    ``close_view`` releases the graphics resources.

    Args:
        theme: Colours of everything except the skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Factories of the layers drawn on the body, by name.

    Attributes:
        display: The picture of the robot.
    """

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, BodyLayerFactory] | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("second-view")
        self.setAccessibleName("Second view of the robot")
        self.setMinimumSize(160, 120)
        self.display = RobotDisplay(self, theme, scale, layers=layers)
        column_layout(self.display.canvas.widget, parent=self)
        self._held: tuple[QPointF, CameraMotion] | None = None
        self.navigation = NavigationStyle.STANDARD
        self._waiting: Frame | None = None
        self._pace = make(QTimer, self, singleShot=True, interval=EVERY_MS, timeout=self._show_waiting)
        self.display.canvas.widget.installEventFilter(self)

    def sizeHint(self) -> QSize:
        return QSize(360, 300)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another robot, fitted to the view."""
        self._pace.stop()
        self._waiting = None
        self.display.show_prepared(prepared)
        self.display.actors.turn_opening(_OTHER_SIDE)
        self.display.frame_all()

    def show_frame(self, frame: Frame) -> None:
        """Show a frame; of frames that arrive within the interval, only the newest is shown."""
        self._waiting = frame
        if not self._pace.isActive():
            self._show_waiting()

    def _show_waiting(self) -> None:
        frame = self._waiting
        self._waiting = None
        if frame is not None and self.display.prepared is not None and len(frame.posture) == self._joints:
            self.take_frame(frame)
            self._pace.start()

    def take_frame(self, frame: Frame) -> None:
        """Show a frame in the next picture."""
        self.display.show_frame(frame)

    @property
    def _joints(self) -> int:
        assert self.display.prepared is not None
        return len(self.display.prepared.robot.joints)

    def close_view(self) -> None:
        """Release the graphics resources; the view draws nothing after this."""
        self._pace.stop()
        self.display.canvas.widget.removeEventFilter(self)
        self.display.close()

    # Qt's events.

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle all mouse and wheel events of the canvas instead of VTK."""
        if isinstance(event, QWheelEvent):
            self.zoom(_WHEEL_STEP ** (event.angleDelta().y() / 120))
            return True
        if not isinstance(event, QMouseEvent):
            return False
        kind = event.type()
        if kind == QEvent.Type.MouseButtonDblClick:
            self.double_click()
        elif kind == QEvent.Type.MouseButtonPress:
            self._held = event.position(), motion_of(self.navigation, event.button(), event.modifiers())
        elif kind == QEvent.Type.MouseButtonRelease:
            self._held = None
        elif self._held is not None:
            before, motion = self._held
            here = event.position()
            self._held = here, motion
            self.display.navigate(here - before, motion)
        return True

    def zoom(self, factor: float) -> None:
        """Zoom by a factor."""
        self.display.look(zoom(self.display.actors.viewpoint, factor))

    def double_click(self) -> None:
        """Fit the whole robot to the view."""
        self.display.frame_all()

    def showEvent(self, event: QShowEvent) -> None:
        """Draw the newest frame."""
        super().showEvent(event)
        self.display.request()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw at the new size."""
        super().resizeEvent(event)
        self.display.resize()


_SHARE = 0.34
_NARROWEST = 130
_WIDEST = 320
_SHAPE = 0.82
"""Fraction of the robot view's width, its bounds [px], and height by width."""
_HALF_HEIGHT = 0.045
_RINGS = 2.6
"""Minimum half height of the picture [m], and half height in radii of the contact's ring."""
_DRIFT = 0.3
_TILT = np.cos(np.radians(25.0))
"""Offset from the centre, as a fraction of the height, and cosine of the tilt beyond which the camera follows."""
_EDGE = 8


class ContactInset(QFrame):
    """Small view in the corner of the robot view that shows the strongest contact from outside the skin.

    A double click shows the contact in the robot view.

    Args:
        theme: Colours of everything except the skin.
        scale: Colours of pressure.
        parent: The robot view; the inset stays in its upper right corner.

    Attributes:
        view: The picture of the contact.
        followed: Contact that is shown; None before the first one.
    """

    look_requested = Signal(SurfacePoint)
    """Request to show this location in the robot view."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget) -> None:
        super().__init__(parent)
        self._around = parent
        self.setObjectName("contact-inset")
        self.setAccessibleName("Contact, enlarged")
        self.setToolTip("Follows the strongest contact; double-click to look there in the robot view")
        self.setStyleSheet("#contact-inset { background: palette(window); border: 1px solid palette(mid); }")
        self.view = _FollowingView(theme, scale, self)
        self.view.double_clicked.connect(self._on_double_clicked)
        self.words = make(QLabel, "No contact yet", self, role="caption")
        self.words.setContentsMargins(6, 1, 6, 2)
        column_layout(self.view, self.words, parent=self, spacing=0, stretch=self.view, margins=(1, 1, 1, 1))
        self.followed: ContactRegion | None = None
        self.view.followed.connect(self._on_followed)
        parent.installEventFilter(self)
        self.place()

    def place(self) -> None:
        """Move to the corner, with a size that fits the robot view."""
        room = self._around.size()
        width = min(max(round(_SHARE * room.width()), _NARROWEST), _WIDEST, room.width())
        self.setGeometry(room.width() - width - _EDGE, _EDGE, width, round(_SHAPE * width))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Stay in the corner."""
        if event.type() == QEvent.Type.Resize:
            self.place()
        return False

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Keep presses from the robot view below."""
        event.accept()

    def close_view(self) -> None:
        """Release the graphics resources."""
        self._around.removeEventFilter(self)
        self.view.close_view()

    def _on_followed(self, region: ContactRegion | None, words: str) -> None:
        self.followed = self.followed if region is None else region
        self.words.setText(words)

    def _on_double_clicked(self) -> None:
        if self.followed is not None:
            self.look_requested.emit(self.followed.at)


class _FollowingView(SecondView):
    """Shows the strongest contact; without one, the camera stays where it is."""

    followed = Signal(ContactRegion, str)
    """The contact in view, or None; and its description."""
    double_clicked = Signal()

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget) -> None:
        super().__init__(theme, scale, parent)
        self.setObjectName("contact-view")
        self.setAccessibleName("Contact, enlarged")
        self.setMinimumSize(80, 60)
        self.display.overlay.hide()
        self._zoomed = 1.0
        self._configuration: Configuration | None = None

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another robot, without a contact yet."""
        super().show_prepared(prepared)
        self._configuration = Configuration(prepared.robot)
        self.followed.emit(None, "No contact yet")

    def take_frame(self, frame: Frame) -> None:
        """Show a frame, and follow the contact."""
        super().take_frame(frame)
        region = max(frame.regions, key=lambda one: one.force, default=None)
        if region is None:
            self.followed.emit(None, "No contact")
            return
        unit = frame.units.force
        value = f"{region.force:.1f}\u202f{unit}" if unit else f"{region.force:.3g}"
        self.followed.emit(region, f"{region.link.replace('_', ' ')}, {value}")
        self._follow(frame, region)

    def _follow(self, frame: Frame, region: ContactRegion) -> None:
        configuration = self._configuration
        if configuration is None:
            return
        configuration.update(frame.posture)
        pose = configuration.pose(region.link)
        point = pose.points(region.link_position)
        normal = pose.rotation @ region.link_normal
        half = max(_HALF_HEIGHT, _RINGS * ring_radius(region)) / self._zoomed
        view = self.display.actors.viewpoint
        if not _is_framed(view, point, normal, half):
            focus = replace(view, eye=point + (view.eye - view.focus), focus=point)
            away = half / np.tan(np.radians(view.view_angle) / 2)
            self.display.look(zoom(look_from(focus, normal), focus.distance / away))

    def navigate(self, by: QPointF, motion: CameraMotion) -> None:
        """Ignored: the camera follows the contact."""

    def zoom(self, factor: float) -> None:
        """Zoom by a factor, and keep the zoom for later contacts."""
        self._zoomed = float(np.clip(self._zoomed * factor, 0.1, 10.0))
        super().zoom(factor)

    def double_click(self) -> None:
        """Request to show the contact in the robot view."""
        self.double_clicked.emit()


def _is_framed(view: Viewpoint, point: FloatArray, normal: FloatArray, half: float) -> bool:
    """Whether a contact is near the centre, seen from outside, and at about the right distance."""
    away = view.eye - point
    distance = float(np.linalg.norm(away))
    best = half / np.tan(np.radians(view.view_angle) / 2)
    off = float(np.linalg.norm(point - view.focus))
    return off < _DRIFT * half and float(away @ normal) > _TILT * distance and 0.7 < distance / best < 1.4

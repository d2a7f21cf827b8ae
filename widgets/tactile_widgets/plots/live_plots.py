"""Live plots of the last seconds: forces, pressures, milliseconds by stage, the controller's response and its limits.

The controller's task determines which of them are shown, so that they stay few: the response of a controller with a
task replaces pressure unless taxels are selected. If there is not enough room, the milliseconds, which also have a
panel, are hidden. The user can choose other plots, and add a raster of all taxels and plots of single taxels, contacts,
links, joints, limits and events.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QElapsedTimer, QPoint, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QToolButton, QWidget

from tactile_maps.contacts.events import EVENT_KINDS
from tactile_maps.control.controller_registry import TASKS_AT_A_PLACE, effective_settings, has_task
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import SpeedScale
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.core.arrays import FloatArray, IntArray, length
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import column_layout, make, row_layout
from tactile_widgets.document.taxel_selection import TaxelSelection
from tactile_widgets.plots.choice.plot_choice import (
    OF_GROUPS,
    OF_SHEAR,
    RASTER,
    STANDARD,
    PlotChoice,
    PlotKey,
    PlotKind,
    TaxelGroup,
)
from tactile_widgets.plots.plot_board import PlotBoard, PlotCell
from tactile_widgets.plots.traces.chosen_traces import SourcedTrace, StageAreas, TraceSource
from tactile_widgets.plots.traces.group_traces import GroupPressure, GroupSamples
from tactile_widgets.plots.traces.history import (
    EventHistory,
    LimitHistory,
    SampleHistory,
    SettingChanges,
    VectorHistory,
    stage_times,
)
from tactile_widgets.plots.traces.raster import RasterPlot
from tactile_widgets.plots.traces.span_strip import EventStrip, LimitStrip
from tactile_widgets.plots.traces.trace_plots import (
    PLOT_SECONDS,
    ForceTraces,
    PlotPart,
    PressureTraces,
    TracePlot,
    error_of,
    error_trace,
    peak_title,
    speed_trace,
)

REDRAW_MS = 100
"""Plots are redrawn at most this often; samples in between are kept, not drawn."""
REST = 8.0
"""Minimum redraw interval as a multiple of the time the last update of the curves took. Painting takes about as long
again, so plots use at most a quarter of the window's time, and the rest is left for the body and map views."""
MAX_REST_MS = 1000
"""Maximum redraw interval: on a busy computer one update may take seconds, and the curves must still end at *now*."""
SIDE_BY_SIDE_ASPECT = 1.6
LOWEST = 118
USUAL_HEIGHT = 140
"""Minimum and usual height of plots side by side [px]."""
ENLARGED_SHARE = 0.36
"""Share of the window's height for an enlarged plot."""
MIN_PLOT_WIDTH = 190
"""Minimum width of a plot next to others [px]."""
_BETWEEN_MS = 25
"""Time after a frame at which paced plots are updated, between two pictures of the body and map views."""
_STRETCH = 3
_FORCE, _ERROR, _SPEED, _LIMITS, _PRESSURE, _TIME, _EVENTS = STANDARD
_SMALLEST_SPAN = {False: 0.1, True: 0.01}
"""Minimum range of the axis of a joint position, by whether the joint slides: [rad] if not, [m] if it does."""


def _members(text: str) -> IntArray:
    """Return the taxels (n,) of a group in text form."""
    group = TaxelGroup.parse(text)
    return np.array(() if group is None else group.taxels, dtype=np.intp)


def _shear_of(frame: Frame) -> FloatArray:
    """Return the sum of the contacts' forces along the skin [N], and the highest friction in use [%]; or NaN."""
    if frame.shear is None:
        return np.full(2, np.nan)
    found = [region.shear for region in frame.regions if region.shear is not None]
    force = sum(length(np.array(one.force)) for one in found)
    return np.array([force, 100 * max((one.usage for one in found), default=0.0)])


class PlotGroup(NamedTuple):
    """Plots that can be added, with their heading."""

    title: str
    keys: tuple[PlotKey, ...]


class LivePlots(QWidget):
    """Small plots with one time axis: now at the right, ten seconds ago at the left; changed settings are marked."""

    region_forgotten = Signal(int)
    """The last sample of the contact region with this id was dropped."""
    choice_changed = Signal()
    """The user chose other plots, or another order."""
    menu_requested = Signal(PlotKey, QPoint)
    """The context menu of a plot is requested at this position of the screen."""
    taxel_clicked = Signal(int)
    """The row of this taxel was clicked."""
    time_clicked = Signal(float)
    """A bar that began at this time [s] was clicked."""
    enlarged_changed = Signal(bool)
    """Emitted with True when one plot fills the board and needs more height, with False when it no longer does."""

    def __init__(self, theme: Theme, parent: QWidget | None = None, *, paced: bool = False) -> None:
        super().__init__(parent)
        self._paced = paced
        self.setObjectName("live-plots")
        self.setAccessibleName("Live plots")
        self._theme = theme
        self._scale = PressureScale()
        self._settings = ControlSettings()
        self._prepared: PreparedScene | None = None
        self._latest: Frame | None = None
        self._make_memory()
        self._since_drawn = QElapsedTimer()
        self._dirty = False
        self._late = make(QTimer, self, singleShot=True, timeout=self._on_late)
        self._undrawn: list[PlotKey] = []
        self._drawing_ns = 0
        self._rest_ms = REDRAW_MS
        self._units = ReadingUnits.CALIBRATED
        self._selection: TaxelSelection | None = None
        self._choice = PlotChoice()
        self.board = PlotBoard(theme, self)
        self.board.move_requested.connect(self.move_plot)
        self.board.window_closed.connect(self._on_window_closed)
        self.board.enlarged_changed.connect(self.enlarged_changed)
        self._parts: dict[PlotKey, PlotPart] = {}
        self._trace_plots: dict[PlotKey, TracePlot] = {}
        self._make_plots(theme)
        self._row = row_layout(self.board, parent=self, stretch=self.board, margins=(12, 8, 12, 8))
        self.setMinimumSize(200, LOWEST)
        self.set_theme(theme)
        self._arrange()

    def _make_memory(self) -> None:
        self._stages = SampleHistory(seconds=PLOT_SECONDS)
        self._links = SampleHistory(seconds=PLOT_SECONDS)
        self._posture = VectorHistory(seconds=PLOT_SECONDS)
        self._velocity = VectorHistory(seconds=PLOT_SECONDS)
        self._shear = VectorHistory(seconds=PLOT_SECONDS)
        self._limits = LimitHistory(seconds=PLOT_SECONDS)
        self._changes = SettingChanges(seconds=PLOT_SECONDS)
        self._events = EventHistory(seconds=PLOT_SECONDS)

    def _make_plots(self, theme: Theme) -> None:
        titles = {
            _FORCE: (ReadingUnits.CALIBRATED.strength_title, 5.0),
            _PRESSURE: (peak_title(ReadingUnits.CALIBRATED), 5.0),
            _TIME: ("Time per tick (ms)", 1.0),
            _ERROR: ("Error on the map (mm)", 10.0),
            _SPEED: ("Max joint speed (rad/s)", 2.0),
        }
        plots = {key: self._add_plot(key, *title) for key, title in titles.items()}
        self._force = ForceTraces(plots[_FORCE], theme)
        self._pressure = PressureTraces(plots[_PRESSURE], theme)
        self._error = error_trace(plots[_ERROR], theme)
        self._speed = speed_trace(plots[_SPEED], theme)
        self._speed_scale = SpeedScale()
        self._areas = StageAreas(plots[_TIME], self._stages, theme)
        self._strip = LimitStrip(self._limits, self._ages, theme, self)
        self._parts |= {
            _FORCE: self._force,
            _PRESSURE: self._pressure,
            _TIME: self._areas,
            _ERROR: self._error,
            _SPEED: self._speed,
            _LIMITS: self._add_strip(_LIMITS, self._strip),
            _EVENTS: self._add_strip(_EVENTS, EventStrip(self._events, self._ages, theme, self)),
        }

    def _ages(self) -> Sequence[float]:
        return self._changes.ages

    def _add_plot(self, key: PlotKey, title: str, floor: float) -> TracePlot:
        plot = self._trace_plots[key] = TracePlot(title, floor, self)
        self._connect(self.board.add(key, plot, _STRETCH))
        return plot

    def _add_strip(self, key: PlotKey, strip: LimitStrip | EventStrip) -> PlotPart:
        cell = self.board.add(key, strip, _STRETCH)
        cell.clicked.connect(strip.click)
        strip.clicked.connect(self._on_age_clicked)
        self._connect(cell)
        return strip

    def _add_raster(self, key: PlotKey) -> PlotPart:
        raster = RasterPlot(self._pressure.taxels, self._theme, self._scale, self)
        raster.show_skin(None if self._prepared is None else self._prepared.skin)
        raster.set_units(self._units)
        raster.taxel_clicked.connect(self.taxel_clicked)
        cell = self.board.add(key, raster, _STRETCH)
        cell.clicked.connect(raster.click)
        self._connect(cell)
        return raster

    @property
    def raster(self) -> RasterPlot | None:
        """Raster of all taxels; None if it is not shown."""
        part = self._parts.get(RASTER)
        return part if isinstance(part, RasterPlot) else None

    def _connect(self, cell: PlotCell) -> None:
        cell.menu_requested.connect(partial(self.menu_requested.emit, cell.key))

    def offer(self, actions: Sequence[QAction]) -> None:
        """Add buttons for these actions next to the plots."""
        buttons = [
            make(
                QToolButton,
                self,
                defaultAction=action,
                autoRaise=True,
                objectName=f"plots-{action.objectName()}",
                text=f"{action.iconText().split()[0]}…",  # both open a dialog; the tool tip is the whole text
                toolButtonStyle=Qt.ToolButtonStyle.ToolButtonTextOnly,
            )
            for action in actions
        ]
        self._row.addLayout(column_layout(*buttons, None, spacing=4))

    # What is shown.

    @property
    def shown(self) -> tuple[str, ...]:
        """Shown plots from left to right as text: ``force``, ``error``, ``joint:elbow``, …"""
        return tuple(key.text for key in self.shown_keys)

    @property
    def shown_keys(self) -> tuple[PlotKey, ...]:
        """Shown plots from left to right."""
        return self._choice.shown(self._called_for)

    @property
    def choice(self) -> PlotChoice:
        """Plots that the user chose, with the current geometry of their windows."""
        choice = self._choice
        for key, where in self.board.windows.items():
            choice = choice.with_window(key, where)
        return choice

    def choose(self, choice: PlotChoice) -> None:
        """Restore a stored choice."""
        for key in self.board.windows:
            self.board.close_window(key)
        self._take(choice)
        for key, where in choice.windows.items():
            if key in self.shown_keys:
                self.board.open_window(key, where)

    @property
    def theme(self) -> Theme:
        """Current theme."""
        return self._theme

    def content(self, key: PlotKey) -> QWidget | None:
        """Return the widget of a plot; None if the plot does not exist."""
        cell = self.board.cell(key)
        return None if cell is None else cell.content

    def draw(self) -> None:
        """Draw the shown plots even if the widget is not visible."""
        self._redraw()

    def add_plot(self, key: PlotKey) -> None:
        """Show one more plot."""
        self._take(self._choice.with_plot(key, self._called_for))

    def remove_plot(self, key: PlotKey) -> None:
        """Remove a plot."""
        self.board.close_window(key)
        self._take(self._choice.without(key, self._called_for))

    def move_plot(self, key: PlotKey, before: PlotKey | None) -> None:
        """Move a plot to the left of another, or to the end."""
        self._take(self._choice.moved(key, before))

    def show_called_for(self) -> None:
        """Let the controller determine which standard plots are shown."""
        self._take(PlotChoice(self._choice.order, None, self._choice.windows))

    def keep_standard(self) -> None:
        """Keep the standard plots that are shown now, whichever controller follows."""
        self._take(PlotChoice(self._choice.order, self._called_for, self._choice.windows))

    def pop_out(self, key: PlotKey) -> None:
        """Move a plot to a separate window, or back to the board."""
        if key in self.board.windows:
            self.board.close_window(key)
            self._on_window_closed(key)
        else:
            self.board.open_window(key, None)
            self._take(self._choice.with_window(key, None))

    def _on_window_closed(self, key: PlotKey) -> None:
        self._take(self._choice.without_window(key))

    def _take(self, choice: PlotChoice) -> None:
        if choice == self._choice:
            return
        self._choice = choice
        for key in [key for key in self._parts if key not in choice.order]:
            self.board.remove(key)
            del self._parts[key]
            self._trace_plots.pop(key, None)
        self._undrawn = []  # of the earlier choice
        for key in choice.order:
            if key not in self._parts:
                self._parts[key] = self._make_part(key)
        self._arrange()
        self._redraw_if_seen()
        self.choice_changed.emit()

    def _make_part(self, key: PlotKey) -> PlotPart:
        """Create the plot of a key that the user added."""
        if key.kind is PlotKind.RASTER:
            return self._add_raster(key)
        if key.kind is PlotKind.LIMIT:
            strip = LimitStrip(self._limits, self._ages, self._theme, self, only=(key.of,))
            return self._add_strip(key, strip)
        if key.kind is PlotKind.EVENT:
            return self._add_strip(key, EventStrip(self._events, self._ages, self._theme, self, only=(key.of,)))
        signed = key.kind in (PlotKind.JOINT, PlotKind.JOINT_SPEED)
        if key.kind is PlotKind.GROUP_PRESSURE:
            plot = self._add_plot(key, key.title, 1.0)
            samples = partial(self._group_pressures, key.of)
            return GroupPressure(plot, self._theme, name=key.title, source=samples)
        plot = self._add_plot(key, key.title, _SMALLEST_SPAN[self._slides(key.of)] if signed else 1.0)
        source = partial(self._source, key)
        return SourcedTrace(plot, self._theme, name=key.title, source=source, signed=signed)

    def _source(self, key: PlotKey) -> TraceSource:
        units = self._units
        match key.kind:
            case PlotKind.TAXEL:
                known = self._prepared is None or int(key.of) < len(self._prepared.skin)
                missing = "" if known else "this skin has no such taxel"
                return TraceSource(units.unit, partial(self._pressure.taxel, int(key.of)), missing)
            case PlotKind.CONTACT:
                return TraceSource(units.force or "relative", partial(self._force.contact, key.of))
            case PlotKind.LINK:
                known = self._prepared is None or key.of in self._prepared.robot.link_index
                missing = "" if known else "this robot has no such link"
                return TraceSource(units.force or "relative", partial(self._links.series, key.of), missing)
            case PlotKind.GROUP_FORCE:
                missing = self._no_group(key.of) or ("" if units.force else "uncalibrated readings have no force")
                return TraceSource(units.force or "N", partial(self._group_force, key.of), missing)
            case PlotKind.SHEAR | PlotKind.FRICTION:
                return self._shear_source(key)
        return self._joint_source(key)

    def _shear_source(self, key: PlotKey) -> TraceSource:
        known = self._prepared is None or self._prepared.skin.three_axis.any()
        missing = "" if known else "these taxels do not measure shear"
        if key.kind is PlotKind.FRICTION:
            return TraceSource("%", partial(self._shear.series, 1), missing)
        if self._units.force is None:
            missing = missing or "uncalibrated readings have no force"
        return TraceSource(self._units.force or "N", partial(self._shear.series, 0), missing)

    def _no_group(self, group: str) -> str:
        """Return why the skin does not have this group of taxels; empty if it does."""
        known = self._prepared is None or int(_members(group).max()) < len(self._prepared.skin)
        return "" if known else "this skin has no such taxels"

    def _group_force(self, group: str) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s] and the sum of pressure times area (k,) [N]."""
        taxels = _members(group)
        prepared = self._prepared
        if prepared is None or self._units.force is None or self._no_group(group):
            return np.zeros(0), np.zeros(0)
        ages, kilopascals = self._pressure.group(taxels)
        return ages, 1e3 * kilopascals @ prepared.skin.areas[taxels] if len(ages) else np.zeros(0)

    def _group_pressures(self, group: str) -> GroupSamples:
        ages, values = self._pressure.group(_members(group))
        return GroupSamples(self._units.unit, ages, values.mean(axis=1), values.max(axis=1), self._no_group(group))

    def _joint_source(self, key: PlotKey) -> TraceSource:
        number = self._joint_number(key.of)
        speed = key.kind is PlotKind.JOINT_SPEED
        unit = ("m" if self._slides(key.of) else "rad") + ("/s" if speed else "")
        samples = partial((self._velocity if speed else self._posture).series, -1 if number is None else number)
        if number is None or self._prepared is None:
            return TraceSource(unit, samples, "" if self._prepared is None else "this robot has no such joint")
        joint = self._prepared.robot.joints[number]
        return TraceSource(unit, samples, bounds=() if speed else (joint.lower, joint.upper))

    def _joint_number(self, name: str) -> int | None:
        joints = () if self._prepared is None else self._prepared.robot.joints
        return next((number for number, joint in enumerate(joints) if joint.name == name), None)

    def _slides(self, name: str) -> bool:
        number = self._joint_number(name)
        return self._prepared is not None and number is not None and self._prepared.robot.joints[number].slide

    @property
    def offered(self) -> tuple[PlotGroup, ...]:
        """All plots that can be added now except those of taxels; of the taxel groups, those that are shown."""
        prepared = self._prepared
        frame = self._latest
        links = () if prepared is None else prepared.skin.links
        joints = () if prepared is None else prepared.robot.joint_names
        contacts = () if frame is None else frame.regions
        subjects: dict[str, tuple[PlotKind, Sequence[str]]] = {
            "Contacts now": (PlotKind.CONTACT, [str(region.id) for region in contacts]),
            "Forces on links": (PlotKind.LINK, links),
            "Joints": (PlotKind.JOINT, joints),
            "Speeds of joints": (PlotKind.JOINT_SPEED, joints),
            "Contact events of one kind": (PlotKind.EVENT, EVENT_KINDS),
            "Single limits": (PlotKind.LIMIT, [kind.value for kind in LimitKind]),
        }
        groups = [
            PlotGroup(title, tuple(PlotKey(kind, of) for of in names)) for title, (kind, names) in subjects.items()
        ]
        named = tuple(key for key in self._choice.order if key.kind in OF_GROUPS)
        groups.insert(0, PlotGroup("Groups of taxels", named))
        return PlotGroup("Standard", (*STANDARD, RASTER, *OF_SHEAR)), *(group for group in groups if group.keys)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self.board.set_theme(theme)
        for part in self._parts.values():
            part.set_theme(theme)

    def set_scale(self, scale: PressureScale) -> None:
        """Set the colours of pressures."""
        self._scale = scale
        if self.raster is not None:
            self.raster.set_scale(scale)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the current controller settings: their goals are drawn, and the time of a change is marked."""
        if settings != self._settings:
            self._changes.change()
        self._settings = settings
        has_force_goal = settings.controller == "hold_force" or (
            has_task(settings.controller) and "force_goal" in effective_settings(settings)
        )
        self._force.set_goal(settings.force_goal if has_force_goal else None)
        self._arrange()
        self._redraw_if_seen()

    @property
    def _called_for(self) -> frozenset[PlotKey]:
        """Standard plots that matter for the current controller, as far as they fit."""
        settings = self._settings
        selected = self._selection is not None and bool(len(self._selection.taxels))
        keys = [_FORCE]
        if has_task(settings.controller):
            at_a_place = settings.task in TASKS_AT_A_PLACE
            keys += [_ERROR, _SPEED, _LIMITS] if at_a_place else [_SPEED, _LIMITS]
            keys += [_PRESSURE] if selected or not at_a_place else []
        else:
            keys += [_LIMITS, _PRESSURE] if settings.controller == "hold_force" else [_PRESSURE]
        added = len(self._choice.order) - len(STANDARD)
        if not self._horizontal or (len(keys) + added + 1) * MIN_PLOT_WIDTH <= self.width():
            keys.append(_TIME)
        return frozenset(keys)

    def _arrange(self) -> None:
        self.board.arrange(self.shown_keys)

    @property
    def _horizontal(self) -> bool:
        """Whether the plots are side by side."""
        return self.width() >= SIDE_BY_SIDE_ASPECT * self.height()

    def sizeHint(self) -> QSize:
        """Return the smallest height that shows all plots; a higher place is filled."""
        return QSize(super().sizeHint().width(), self.minimumHeight())

    def preferred_height(self, window_height: int, *, low: bool) -> int:
        """Return the height of the plots in a window of this height [px]; ``low`` if the views need the room."""
        usual = LOWEST if low else USUAL_HEIGHT
        return usual if self.board.enlarged is None else max(usual, round(ENLARGED_SHARE * window_height))

    def follow(self, selection: TaxelSelection) -> None:
        """Trace what is selected there, including its past."""
        self._selection = selection
        selection.changed.connect(self._on_selection_changed)
        selection.region_changed.connect(self._force.select)
        self.region_forgotten.connect(selection.forget_region)
        self._on_selection_changed()
        self._force.select(selection.region)

    def _on_selection_changed(self) -> None:
        if self._selection is not None:
            self._pressure.select(self._selection.taxels, self._selection.inks)
            self._arrange()

    # What is kept.

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another scene, whose joints and links can be plotted."""
        self._prepared = prepared
        if self.raster is not None:
            self.raster.show_skin(prepared.skin)
        scale = self._speed_scale = SpeedScale(prepared.robot)
        self._speed.use(f"Max joint speed ({scale.unit})", unit=scale.unit, bound=scale.bound)
        self.clear()

    def clear(self) -> None:
        """Discard all samples, for another session."""
        for part in (self._force, self._pressure, self._error, self._speed, self._areas):
            part.clear()
        for memory in (
            self._limits,
            self._changes,
            self._stages,
            self._links,
            self._posture,
            self._velocity,
            self._shear,
            self._events,
        ):
            memory.clear()
        self._latest = None
        self._redraw()

    def show_frame(self, frame: Frame) -> None:
        """Store the values of ``frame``, and draw them if a redraw is due and the plots are visible."""
        gone = self._keep(frame)
        if not self._since_drawn.isValid() or self._since_drawn.elapsed() >= self._rest_ms:
            if not self._paced:
                self._redraw_if_seen()
            elif not self._late.isActive() or self._late.interval() != _BETWEEN_MS:  # else frames would postpone it
                self._late.start(_BETWEEN_MS)
        elif not self._late.isActive():
            self._late.start(self._rest_ms)
        for region in gone:
            self.region_forgotten.emit(region)

    def keep(self, frames: Sequence[Frame]) -> None:
        """Store the values of frames that no view shows; they are drawn with the next frame. Cost: 0.1 ms each."""
        for frame in frames:
            for region in self._keep(frame):
                self.region_forgotten.emit(region)

    def show_past(self, frames: Sequence[Frame]) -> None:
        """Show only these frames."""
        self.clear()
        self.keep(frames)
        self._redraw_if_seen()

    def _keep(self, frame: Frame) -> tuple[int, ...]:
        """Store the values of a frame; return the ids of the regions whose last sample was dropped."""
        time = frame.time
        if frame.units is not self._units:
            self._units = frame.units
            self._force.set_units(frame.units)
            self._pressure.set_units(frame.units)
            if self.raster is not None:
                self.raster.set_units(frame.units)
            self._links.clear()
        self._latest = frame
        gone = self._force.add(time, frame.regions, frame.task.force_goal if frame.task else None)
        self._pressure.add(time, frame.pressures)
        self._error.add(time, error_of(frame))
        self._speed.add(time, self._speed_scale.value(frame.velocity))
        self._limits.take(time, frame.why_limited)
        self._changes.at(time)
        self._stages.add(time, stage_times(frame.timings))
        self._links.add(time, self._link_forces(frame))
        self._posture.add(time, frame.posture)
        self._velocity.add(time, frame.velocity)
        self._shear.add(time, _shear_of(frame))
        self._events.take(time, frame.recent)
        self._dirty = True
        return gone

    def _link_forces(self, frame: Frame) -> dict[str, float]:
        """Return the sum of contact forces of each link touched so far, 0 for links without contact now."""
        forces = dict.fromkeys(self._links.names, 0.0)
        forces |= {key.of: 0.0 for key in self._parts if key.kind is PlotKind.LINK}
        for region in frame.regions:
            forces[region.link] = forces.get(region.link, 0.0) + region.force
        return forces

    # Drawing.

    def _on_late(self) -> None:
        """Draw the next plot, also if no frame followed the last one, because time is paused."""
        if not self._undrawn and self._dirty and self._seen:
            self._begin_drawing()
        if self._undrawn:
            self._draw_next()
            if self._undrawn:
                self._late.start(0)  # the window responds between two plots
            elif self._dirty:
                self._late.start(self._rest_ms)

    @property
    def _seen(self) -> bool:
        return self.isVisible() or bool(self.board.windows)

    def _redraw_if_seen(self) -> None:
        if self._seen:
            self._redraw()

    def _redraw(self) -> None:
        """Draw the shown plots at once; hidden ones keep their samples until they are shown."""
        self._begin_drawing()
        while self._undrawn:
            self._draw_next()

    def _begin_drawing(self) -> None:
        self._since_drawn.start()
        self._drawing_ns = 0
        self._dirty = False
        self._undrawn = list(self.shown_keys)

    def _draw_next(self) -> None:
        key = self._undrawn.pop(0)
        began = self._since_drawn.nsecsElapsed()
        self._parts[key].draw()
        if key in self._trace_plots:
            self._trace_plots[key].mark(self._ages())
        self._drawing_ns += self._since_drawn.nsecsElapsed() - began
        self._rest_ms = min(max(REDRAW_MS, round(REST * 1e-6 * self._drawing_ns)), MAX_REST_MS)

    def _on_age_clicked(self, age: float) -> None:
        if self._latest is not None:
            self.time_clicked.emit(self._latest.time + age)

    def table(self, keys: Sequence[PlotKey] | None = None) -> str:
        """Return samples of these plots (default: the shown ones) as CSV, a row per sample with its time [s]."""
        written = io.StringIO()
        now = 0.0 if self._latest is None else self._latest.time
        rows = csv.writer(written, lineterminator="\n")
        rows.writerow(("plot", "series", "unit", "time_s", "value"))
        for key in self.shown_keys if keys is None else keys:
            for series in self._parts[key].series():
                for age, value in zip(series.ages.tolist(), series.values.tolist(), strict=True):
                    if np.isfinite(value):
                        rows.writerow((key.title, series.name, series.unit, f"{now + age:.6g}", f"{value:.6g}"))
        return written.getvalue()

    def showEvent(self, event: QShowEvent) -> None:
        """Draw the samples that arrived while the widget was hidden."""
        super().showEvent(event)
        if self._dirty:
            self._redraw()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange the plots side by side in a wide widget, one below the other in a tall one."""
        super().resizeEvent(event)
        self.board.set_horizontal(horizontal=self._horizontal)
        self._arrange()

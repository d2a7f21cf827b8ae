"""Makes the presenters, each with those it asks: one acyclic order, so that nobody reaches through the window."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtWidgets import QWidget

from tactile_widgets.context.app_context import AppContext
from tactile_widgets.presenters.control.comparison_presenter import ComparisonPresenter
from tactile_widgets.presenters.control.control_presenter import ControlPresenter, ControlToolsPresenter
from tactile_widgets.presenters.control.posture_presenter import PosturePresenter
from tactile_widgets.presenters.files.export_presenter import ExportPresenter
from tactile_widgets.presenters.files.figure_presenter import FigurePresenter
from tactile_widgets.presenters.files.file_presenter import FilePresenter
from tactile_widgets.presenters.files.film_presenter import FilmPresenter
from tactile_widgets.presenters.files.recordings_presenter import RecordingsPresenter
from tactile_widgets.presenters.files.study_presenter import StudyPresenter
from tactile_widgets.presenters.maps.map_edit_presenter import MapEditPresenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter
from tactile_widgets.presenters.notification_presenter import NotificationPresenter
from tactile_widgets.presenters.plots_presenter import PlotsPresenter
from tactile_widgets.presenters.pointing_presenter import PointingPresenter
from tactile_widgets.presenters.session.accuracy_presenter import AccuracyPresenter
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter
from tactile_widgets.presenters.session.faults_presenter import FaultsPresenter
from tactile_widgets.presenters.session.notes_presenter import NotesPresenter
from tactile_widgets.presenters.session.overlay_presenter import OverlayPresenter
from tactile_widgets.presenters.session.recording_plots_presenter import RecordingPlotsPresenter
from tactile_widgets.presenters.session.replay_past import ReplayPast
from tactile_widgets.presenters.session.scene_presenter import ScenePresenter
from tactile_widgets.presenters.session.session_presenter import LiveInputPresenter, SessionPresenter
from tactile_widgets.presenters.session.touch_script_presenter import TouchScriptPresenter
from tactile_widgets.presenters.state_tracker import StateTracker
from tactile_widgets.presenters.touch_presenter import TouchPresenter
from tactile_widgets.presenters.view_presenter import ViewPresenter
from tactile_widgets.tools.map_editing.grid_tool import GridTool
from tactile_widgets.tools.registry import Tools


@dataclass(frozen=True, eq=False)
class Presenters:
    """All of them, and the tools that they share."""

    tools: Tools
    effects: EffectsPresenter
    faults: FaultsPresenter
    map_files: MapFilePresenter
    map_edit: MapEditPresenter
    files: FilePresenter
    export: ExportPresenter
    recordings: RecordingsPresenter
    studies: StudyPresenter
    overlay: OverlayPresenter
    live_input: LiveInputPresenter
    view: ViewPresenter
    session: SessionPresenter
    notes: NotesPresenter
    recording_plots: RecordingPlotsPresenter
    replay_past: ReplayPast
    notification: NotificationPresenter
    plots: PlotsPresenter
    figure: FigurePresenter
    film: FilmPresenter
    touch: TouchPresenter
    pointing: PointingPresenter
    touch_script: TouchScriptPresenter
    control_tools: ControlToolsPresenter
    control: ControlPresenter
    posture: PosturePresenter
    comparison: ComparisonPresenter
    accuracy: AccuracyPresenter
    scene: ScenePresenter
    state: StateTracker

    def close(self) -> None:
        """Finish writing, end what runs beside."""
        for presenter in (
            self.export,
            self.map_files,
            self.accuracy,
            self.comparison,
            self.session,
            self.replay_past,
            self.recording_plots,
            self.recordings,
            self.studies,
            self.plots,
            self.film,
            self.overlay,
        ):
            presenter.close()


def build(context: AppContext, parent: QWidget) -> Presenters:
    """The presenters of a window; ``parent`` owns them."""
    tools = Tools(context.editor, parent)
    effects = EffectsPresenter(context, parent)
    map_files = MapFilePresenter(context, parent)
    map_edit = MapEditPresenter(context, tools, map_files, parent)
    studies = StudyPresenter(context, parent)
    files = FilePresenter(context, effects, map_files, studies, tools.get(GridTool), parent)
    plots = PlotsPresenter(context, parent)
    figure = FigurePresenter(context, parent)
    overlay = OverlayPresenter(context, parent)
    touch = TouchPresenter(context, parent)
    return Presenters(
        tools=tools,
        effects=effects,
        faults=FaultsPresenter(context, parent),
        map_files=map_files,
        map_edit=map_edit,
        files=files,
        recordings=RecordingsPresenter(context, files, overlay, parent),
        studies=studies,
        overlay=overlay,
        export=ExportPresenter(context, parent),
        live_input=LiveInputPresenter(context, map_files, parent),
        view=ViewPresenter(context, tools, parent),
        session=SessionPresenter(context, parent),
        recording_plots=RecordingPlotsPresenter(context, parent),
        notes=NotesPresenter(context, tools, parent),
        replay_past=ReplayPast(context, parent),
        notification=NotificationPresenter(context, touch, parent),
        plots=plots,
        figure=figure,
        film=FilmPresenter(context, parent),
        touch=touch,
        pointing=PointingPresenter(context, tools, touch, plots, figure, parent),
        touch_script=TouchScriptPresenter(context, effects, parent),
        control_tools=ControlToolsPresenter(context, tools, parent),
        control=ControlPresenter(context, parent),
        posture=PosturePresenter(context, tools, parent),
        comparison=ComparisonPresenter(context, effects, parent),
        accuracy=AccuracyPresenter(context, effects, parent),
        scene=ScenePresenter(context, effects, map_edit, parent),
        state=StateTracker(context, tools, overlay, map_files, parent),
    )

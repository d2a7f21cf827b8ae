"""Registry of the tools, one entry each. ``Tools`` creates them and manages the active tool, and undo of all edits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from PySide6.QtCore import QObject, Signal

from tactile_widgets.common.tool_kinds import POKE, SELECT_BOX, SELECT_BRUSH, SELECT_LASSO, ToolKind, ToolRole
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.posture_editor import PostureEditor
from tactile_widgets.document.skin_steps import SkinSteps
from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.tools.control.path_tool import PathTool
from tactile_widgets.tools.control.posture_tool import PostureTool
from tactile_widgets.tools.control.target_tool import TargetTool
from tactile_widgets.tools.map_editing.arrange_tool import ArrangeTool
from tactile_widgets.tools.map_editing.grid_tool import GridTool
from tactile_widgets.tools.map_editing.interest_tool import InterestTool
from tactile_widgets.tools.map_editing.pin_tool import PinTool
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.tools.undo import ControlUndo, MapUndo, Undoable, UndoInOrder
from tactile_widgets.views.interaction.view_tool import ViewTool


@dataclass(frozen=True, eq=False)
class ToolContext:
    """Editors that a tool may use.

    Attributes:
        editor: Map editor.
        control: Editor of the controller's path, target and force.
        posture: Editor of the robot's posture.
        parent: Qt parent of the tools.
    """

    editor: MapEditor
    control: ControlSettingsEditor
    posture: PostureEditor
    parent: QObject


@dataclass(frozen=True)
class ToolSpec:
    """Description of a tool.

    Attributes:
        kind: Name and role, which determine the menu and the position in the toolbar.
        text: Menu text.
        key: Shortcut while one of the views has the focus.
        tip: Description in one sentence.
        make: Creates the handler of mouse events; None for a tool that the views implement.
    """

    kind: ToolKind
    text: str
    key: str
    tip: str
    make: Callable[[ToolContext], ViewTool] | None = None


ARRANGE = ToolKind("arrange", ToolRole.EDIT)
PINS = ToolKind("pins", ToolRole.EDIT)
SEAMS = ToolKind("seams", ToolRole.EDIT)
INTEREST = ToolKind("interest", ToolRole.EDIT)
GRID = ToolKind("grid", ToolRole.EDIT)
PATH = ToolKind("draw_path", ToolRole.CONTROL)
TARGET = ToolKind("set_target", ToolRole.CONTROL)
POSTURE = ToolKind("posture", ToolRole.CONTROL)

TOOLS = (
    ToolSpec(POKE, "Poke", "T", "Press the skin to poke it"),
    ToolSpec(
        SELECT_BOX,
        "Select by box",
        "B",
        "Click taxels, or drag a box around them; Ctrl or Shift adds, Alt removes",
    ),
    ToolSpec(
        SELECT_LASSO,
        "Select by lasso",
        "L",
        "Click taxels, or draw a line around them; Ctrl or Shift adds, Alt removes",
    ),
    ToolSpec(
        SELECT_BRUSH,
        "Select by brush",
        "C",
        "Paint over taxels; [ and ] change the brush, Ctrl or Shift adds, Alt removes",
    ),
    ToolSpec(
        ARRANGE,
        "Arrange patches",
        "V",
        "Click patches to select them, drag to move, rotate or scale them",
        lambda context: ArrangeTool(context.editor, context.parent),
    ),
    ToolSpec(
        PINS,
        "Pins",
        "N",
        "Click the skin to pin it to the map, drag pins to deform the map",
        lambda context: PinTool(context.editor, context.parent),
    ),
    ToolSpec(
        SEAMS,
        "Seams",
        "K",
        "Draw seams on body or map where the skin is cut; Alt erases",
        lambda context: SeamTool(context.editor, context.parent),
    ),
    ToolSpec(
        INTEREST,
        "Areas of interest",
        "I",
        "Paint where no seam may go; Alt erases, [ and ] change the brush",
        lambda context: InterestTool(context.editor, context.parent),
    ),
    ToolSpec(
        GRID,
        "Taxel grid",
        "E",
        "Click two opposite corners of an e-skin on the body, and place rows and columns of taxels between them",
        lambda context: GridTool(context.editor, context.parent),
    ),
    ToolSpec(
        PATH,
        "Path",
        "D",
        "Click the corners of a path on map or body, or draw it in one stroke; Enter ends it, drag its corners",
        lambda context: PathTool(context.control, context.parent),
    ),
    ToolSpec(
        TARGET,
        "Target",
        "G",
        "Click on map or body where to hold the contact; drag to move the target",
        lambda context: TargetTool(context.control, context.parent),
    ),
    ToolSpec(
        POSTURE,
        "Drag links",
        "J",
        "Drag a link of the robot: the joints follow; while paused the robot is placed there, else it moves there",
        lambda context: PostureTool(context.posture, context.parent),
    ),
)
"""All tools. Actions, keys, buttons and both views are created from these entries."""


T = TypeVar("T", bound=ViewTool)


class Tools(QObject):
    """All tools and the active one.

    Args:
        editor: Map editor.
        parent: Qt parent.
        specs: Available tools.

    Attributes:
        control: Editor of the controller settings.
        posture: Editor of the robot's posture.
        skin_steps: Changes of the skin.
        active: Active tool.
    """

    changed = Signal(ToolKind)
    """A tool was selected, possibly the same again."""
    undo_changed = Signal()
    """The steps that can be undone or redone may have changed."""

    def __init__(self, editor: MapEditor, parent: QObject | None = None, *, specs: Sequence[ToolSpec] = TOOLS) -> None:
        super().__init__(parent)
        self.specs = tuple(specs)
        self.active = POKE
        self._lent_undo: Undoable | None = None
        self.control = ControlSettingsEditor(self)
        self.posture = PostureEditor(self)
        context = ToolContext(editor, self.control, self.posture, self)
        self._made = {spec.kind: spec.make(context) for spec in specs if spec.make is not None}
        path = self.get(PathTool)
        self.skin_steps = SkinSteps(editor, self)
        self._undo = UndoInOrder(MapUndo(editor, self.skin_steps), ControlUndo(self.control, path), self.posture)
        for signal in (
            self.control.changed,
            path.drawn,
            editor.history_changed,
            editor.gesture_changed,  # undo cancels a drag before it has become a step
            editor.enabled_changed,
            self.skin_steps.changed,
            self.posture.changed,
        ):
            signal.connect(self._on_edited)

    def _on_edited(self) -> None:
        self._undo.note_edit()
        self.undo_changed.emit()

    def take(self, kind: ToolKind) -> None:
        """Activate a tool."""
        self.active = kind
        self.changed.emit(kind)

    @property
    def view_tool(self) -> ViewTool | None:
        """Handler of mouse events of the active tool; None if the views implement it."""
        return self._made.get(self.active)

    @property
    def undo_stack(self) -> Undoable:
        """Undo of map, skin, controller settings and posture in the order of the edits, or the lent stack."""
        return self._undo if self._lent_undo is None else self._lent_undo

    def lend_undo(self, stack: Undoable | None) -> None:
        """Let undo and redo use another stack; None restores the stack of the tools."""
        self._lent_undo = stack
        self.undo_changed.emit()

    def get(self, kind: type[T]) -> T:
        """Return the tool of a class."""
        return next(tool for tool in self._made.values() if isinstance(tool, kind))

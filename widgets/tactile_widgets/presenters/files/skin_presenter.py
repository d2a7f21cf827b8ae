"""The skin of the robot: its choice in the Skin panel with a preview, and covering or clearing a single link."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QMenu, QWidget

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import with_cover, with_link, without_link
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.fitting.cover import MIN_COVER_TAXELS, NO_ROOM, CoverSpec, cover_candidates, hull_area
from tactile_maps.skin.fitting.grid import is_grid_patch
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.make import add_entry
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.jobs.skin_jobs import CoverPlan, SkinPreview
from tactile_widgets.panels.model.skin_panel import SkinChoice, SkinPanel
from tactile_widgets.presenters.files.file_presenter import FilePresenter
from tactile_widgets.presenters.maps.map_file_presenter import MapFilePresenter, UnopenedChoice
from tactile_widgets.presenters.session.effects_presenter import EffectsPresenter
from tactile_widgets.tools.registry import Tools

_NAMED = 4
"""Number of links that a message names."""


class SkinPresenter(Presenter):
    """Connects the Skin panel, its preview, and the steps that undo a change of the skin.

    A choice that is not applied yet is part of the document: it stays when the skin is changed in another way or a
    recording is shown, and is asked about before the document is replaced. So is one for a robot that is not open yet:
    changes of it while the robot is being opened become a choice for its document.

    Args:
        context: Session, views, panels and services of the window.
        effects: Scene with the chosen effects.
        map_files: Documents of the maps of each skin.
        files: Opens a robot with a chosen skin.
        tools: Tools, with the steps of the skin.
        parent: Window over which dialogs open.

    Attributes:
        preview: Fits the skins that are being chosen.
    """

    panels_requested = Signal()
    """The panels must be shown."""

    def __init__(
        self,
        context: AppContext,
        effects: EffectsPresenter,
        map_files: MapFilePresenter,
        files: FilePresenter,
        tools: Tools,
        parent: QWidget,
    ) -> None:
        super().__init__(context, parent)
        self._effects = effects
        self._map_files = map_files
        self._files = files
        self._steps = tools.skin_steps
        self._panel = context.panels.get(SkinPanel)
        self._display = context.views.robot.display
        self._robot: Robot | None = None  # whose links the panel lists
        self._plan: CoverPlan | None = None  # of the scene that is being opened
        self._opening: Scene | None = None  # the panel chooses its skin before it is opened
        self._default = CoverSpec()  # its cover without a choice
        self._applied = CoverSpec()  # of the document
        self.preview = SkinPreview(context.backends.executor("skin preview", self), self)
        self.preview.found.connect(self._panel.show_candidates)
        self.preview.progressed.connect(self._on_progressed)
        self.preview.fitted.connect(self._on_fitted)
        self.preview.failed.connect(self._panel.show_failure)
        panel = self._panel
        panel.needed.connect(self._on_needed)
        panel.edited.connect(self._on_edited)
        panel.reverted.connect(self._on_reverted)
        panel.apply_requested.connect(self._on_apply_requested)
        session = context.session
        session.prepared_changed.connect(self._on_prepared_changed)
        session.scene_jobs.planned.connect(self._on_planned)
        session.loading_ended.connect(self._on_loading_ended)
        session.opening_stopped.connect(self._on_opening_stopped)
        session.mode_changed.connect(self._show_chosen)  # emitted once the document of another scene is shown
        map_files.begun.connect(self._on_document_begun)
        map_files.choice_restored.connect(self._show_chosen)
        map_files.unopened_restored.connect(self._on_unopened_restored)
        map_files.apply_requested.connect(self._on_save_requested)
        map_files.choice_refusal = self._choice_refusal
        for signal in (session.mode_changed, session.recording.changed, session.connection.changed):
            signal.connect(self._on_refusal_changed)
        context.actions.bind(choose_skin=self.show_panel, choose_links=self.show_panel)

    def show_panel(self) -> None:
        """Show the panel; if a robot is being opened with a default skin, stop and let the user choose first."""
        if (plan := self._plan) is not None and self._session.scene_jobs.busy:
            self._session.cancel_loading()
            self._choose_first(plan)
        self.panels_requested.emit()
        self._context.panels.reveal(self._panel)

    # Opening.

    def _on_planned(self, plan: CoverPlan) -> None:
        """Report the links that a robot with a default skin gets."""
        if not plan.scene.cover.links:
            self._plan = plan
            amount = "taxels" if plan.taxels is None else f"{plan.taxels:,} taxels"
            text = f"{Path(plan.scene.robot).stem}: {amount} on {_listed(plan.links)}"
            choose = self._context.actions["choose_links"]
            self._notifier.say(text, remedies=[choose], pending=lambda: self._plan is plan, lasting=True)

    def _on_loading_ended(self) -> None:
        self._plan = None

    def _choose_first(self, plan: CoverPlan) -> None:
        """Let the user choose the skin of a scene that is not open yet."""
        cover = replace(plan.scene.cover, links=plan.links)
        self._map_files.note_unopened(None)
        self._show_unopened(plan.scene, cover, cover)

    def _on_unopened_restored(self, choice: UnopenedChoice) -> None:
        """Show again what a crash left of a choice for a scene that is not open."""
        self._show_unopened(choice.scene, choice.scene.cover, choice.default)
        self.show_panel()

    def _show_unopened(self, scene: Scene, cover: CoverSpec, default: CoverSpec) -> None:
        self._opening = with_cover(scene, cover) if cover.links else scene
        self._default = default
        self._robot = None
        self._display.set_preview(None)
        name = Path(scene.robot).stem
        self._panel.show_choice(SkinChoice(cover, of=name, apply="Open", applicable=True))
        self._on_refusal_changed()

    # The shown skin.

    @property
    def _scene(self) -> Scene | None:
        """Scene that a change begins with."""
        return self._opening or self._effects.scene

    @property
    def refusal(self) -> str:
        """Reason why the skin cannot be changed now; empty if it can."""
        return "" if self._opening is not None else self._refusal_of_shown

    @property
    def _refusal_of_shown(self) -> str:
        """The same, unless the panel shows the skin of a robot that is not open yet."""
        session = self._session
        prepared = session.prepared
        if prepared is None:
            return "Open a robot to choose the links that its skin covers."
        if session.replay.player is not None:
            return "A recording is shown: go back to the live scene to change its skin."
        if session.live_input is not None:
            return "A real skin is connected: disconnect it to change the skin."
        if session.recording.recorder is not None:
            return "A recording is being made: stop it to change the skin."
        if prepared.scene.robot == NO_ROBOT:
            return "These taxels have no robot: open a robot to cover its links."
        return ""

    def _on_refusal_changed(self, *_changed: object) -> None:
        self._panel.show_refusal(self.refusal)

    def _on_prepared_changed(self, prepared: PreparedScene) -> None:
        if self._map_files.unopened is None:  # otherwise the panel shows that until its robot is open
            self._show_prepared(prepared)

    def _on_document_begun(self, chosen: Scene | None) -> None:
        """Show the skin of the robot that was opened; what was changed in the meantime is a choice for it."""
        prepared = self._session.prepared
        if self._opening is None or prepared is None:
            return
        cover = self._panel.cover
        self._show_prepared(prepared)
        if chosen is not None:
            self._note_rebased(cover, chosen.cover)

    def _note_rebased(self, choice: CoverSpec, before: CoverSpec) -> None:
        """Note what a choice changes in ``before`` as a choice for the skin that is applied now."""
        moved = _rebased(choice, before, self._applied)
        self._map_files.note_choice(None if moved == self._applied else moved)

    def _show_prepared(self, prepared: PreparedScene) -> None:
        self.preview.cancel()
        self._opening = None
        cover = _cover(prepared)
        if self._of_document:
            before = self._applied
            self._applied = cover
            if (choice := self._map_files.choice) is not None:
                self._note_rebased(choice, before)
        same = self._robot is not None and _same_robot(self._robot, prepared.robot)
        if not same:
            self.preview.close()
        self._robot = prepared.robot
        files = prepared.scene.taxel_files
        note = f"From {', '.join(files)}; a cover replaces {'it' if len(files) == 1 else 'them'}." if files else ""
        self._panel.show_choice(
            SkinChoice(cover, counts(prepared.skin), bare_links(prepared.skin), note), same_robot=same
        )
        self._on_refusal_changed()

    # The choice that is not applied yet.

    @property
    def _of_document(self) -> bool:
        """Whether the panel shows the skin of the document, or a choice for it."""
        session = self._session
        return self._opening is None and session.replay.player is None and session.live_input is None

    def _note_choice(self) -> None:
        panel = self._panel
        if (scene := self._opening) is not None:
            made = not _same_cover(panel.cover, self._default) or self._map_files.opening_chosen
            choice = UnopenedChoice(replace(scene, cover=panel.cover), self._default)
            self._map_files.note_unopened(choice if made else None)
        elif self._of_document:
            self._map_files.note_choice(panel.cover if panel.different else None)

    def _show_chosen(self, *_changed: object) -> None:
        """Show the choice again after the panel has shown another skin."""
        choice = self._map_files.choice
        panel = self._panel
        if choice is not None and self._of_document and panel.tree.rows and panel.cover != choice:
            panel.choose(choice)

    def _on_opening_stopped(self) -> None:
        """Note a choice again that was being applied."""
        if self._panel.different or self._opening is not None:
            self._note_choice()

    def _choice_refusal(self) -> str:
        """Return why the choice cannot be applied now; an empty text if it can."""
        choice = self._map_files.choice
        return self._refusal_of_shown or ("" if choice is None or choice.links else "Check at least one link.")

    def _on_save_requested(self) -> None:
        """Apply the choice, which is possible now."""
        choice = self._map_files.choice
        scene = self._effects.scene
        if choice is not None and scene is not None:
            with self._notifier.errors_shown("change skin", finishes=False):
                self._apply(with_cover(scene, choice))

    def _apply(self, scene: Scene) -> None:
        self._steps.cancel()  # first, because it notes a choice whose application it cancels
        self._map_files.note_choice(None)
        self._change("Change skin", scene)

    # The panel.

    def _on_needed(self) -> None:
        if self._opening is not None:
            self._panel.show_finding()
            self.preview.show_robot_of(self._opening)
            self.preview.request(self._opening)
        elif self._robot is not None:
            # The areas follow: another process computes them, which may take seconds to start.
            self._panel.show_candidates(cover_candidates(self._robot, measured=False))
            self._show_chosen()
            self.preview.show_robot(self._robot)

    def _on_edited(self) -> None:
        """Preview the choice; show the present skin without a choice."""
        self._note_choice()
        scene = self._scene
        if scene is None or not self._panel.links or not (self._panel.different or self._opening):
            self.preview.cancel()
            self._display.set_preview(None)
            return
        try:
            self.preview.request(with_cover(scene, self._panel.cover))
        except TactileMapsError as error:
            self.preview.cancel()
            self._panel.show_failure(str(error))

    def _on_progressed(self, text: str, _share: float) -> None:
        self._panel.show_progress(text)

    def _on_fitted(self, skin: Skin) -> None:
        self._panel.show_counts(dict.fromkeys(self._panel.links, 0) | counts(skin), bare_links(skin))
        if self._opening is None:
            self._display.set_preview(skin)

    def _on_reverted(self) -> None:
        """Show the present skin again; a robot that is not open yet stays closed."""
        prepared = self._session.prepared
        if self._opening is None:
            self._on_edited()
            return
        self._map_files.note_unopened(None)
        if prepared is not None:
            self._show_prepared(prepared)
            self._show_chosen()
        else:
            self._opening = None
            self.preview.close()
            self._panel.show_nothing()

    def _on_apply_requested(self) -> None:
        scene = self._scene
        if scene is None or self.refusal:
            return
        with self._notifier.errors_shown("change skin", finishes=False):
            changed = with_cover(scene, self._panel.cover)
            if self._opening is None:
                self._apply(changed)
            else:
                self.preview.cancel()
                path = scene.robot if Path(scene.robot).is_file() else None
                self._files.open_scene(changed, recent=path, chosen=True)

    def _change(self, name: str, scene: Scene) -> None:
        """Change the skin to that of a scene, as one step."""
        prepared = self._session.prepared
        if prepared is not None:
            self.preview.cancel()
            self._steps.push(name, prepared.scene, scene)

    # Single links.

    @property
    def coverable(self) -> tuple[str, ...]:
        """Bare links that can be covered now."""
        prepared = self._session.prepared
        if prepared is None or self._refusal_of_shown or prepared.scene.taxel_files:
            return ()
        bare = counts(prepared.skin).keys()
        links = (link for link in prepared.robot.links if link.mesh is not None and not link.missing)
        return tuple(link.name for link in links if link.mesh and len(link.mesh.faces) and link.name not in bare)

    @property
    def removable(self) -> tuple[str, ...]:
        """Links whose skin can be removed now: none if only one has skin."""
        prepared = self._session.prepared
        if prepared is None or self._refusal_of_shown or prepared.scene.taxel_files:
            return ()
        links = tuple(counts(prepared.skin))
        return links if len(links) > 1 else ()

    def cover_link(self, link: str) -> None:
        """Cover a link with as many taxels per area as the others, which stay the same, as one step."""
        prepared = self._session.prepared
        scene = self._effects.scene
        if link not in self.coverable or prepared is None or scene is None:
            return
        first = scene.cover
        more = {name for cover in scene.more_covers for name in cover.links}
        own = first.links or [name for name in counts(prepared.skin) if name not in more]
        others = sum(_area(prepared.robot, name) for name in own)
        taxels = round(first.taxels * _area(prepared.robot, link) / others) if others else first.taxels
        with self._notifier.errors_shown("change skin", finishes=False):
            cover = replace(first, links=(link,), taxels=max(taxels, MIN_COVER_TAXELS), bare=())
            self._change(f"Cover {link}", with_link(scene, cover))

    def remove_skin(self, link: str) -> None:
        """Remove the skin of a link, as one step; the skin of the other links stays the same."""
        prepared = self._session.prepared
        scene = self._effects.scene
        if link not in self.removable or prepared is None or scene is None:
            return
        covered = [patch.link for patch in prepared.skin.patches if not is_grid_patch(patch)]
        self._change(f"Remove skin of {link}", without_link(scene, link, covered))

    def list_coverable(self, menu: QMenu) -> None:
        """List the links that can be covered."""
        _fill(menu, self.coverable, self.cover_link, self._refusal_of_shown or "Every link that has a shape is covered")

    def list_covered(self, menu: QMenu) -> None:
        """List the links whose skin can be removed."""
        _fill(menu, self.removable, self.remove_skin, self._refusal_of_shown or "Only one link has skin")

    def close(self) -> None:
        """End the process of the preview."""
        self.preview.close()


def counts(skin: Skin) -> dict[str, int]:
    """Return the number of taxels of each link with skin."""
    found = Counter[str]()
    for patch in skin.patches:
        found[patch.link] += len(patch.taxels)
    return dict(found)


def bare_links(skin: Skin) -> dict[str, str]:
    """Return the reasons why links, or pieces of them, have no taxels."""
    return {note.where: note.action for note in skin.findings if note.kind == NO_ROOM}


def _listed(links: Sequence[str]) -> str:
    """Return the names of links as words."""
    named = list(links) if len(links) <= _NAMED else [*links[: _NAMED - 1], f"{len(links) - _NAMED + 1} more links"]
    return " and ".join(part for part in (", ".join(named[:-1]), named[-1]) if part)


def _cover(prepared: PreparedScene) -> CoverSpec:
    """Return one cover of all links that have skin, those under grids too; none from taxel files."""
    scene = prepared.scene
    gridded = tuple(dict.fromkeys(grid.link for grid in scene.grids))
    if scene.taxel_files:
        return replace(scene.cover, links=gridded)
    taxels = {link: number for link, number in counts(prepared.skin).items() if link not in gridded}
    several = scene.more_covers or scene.cover.bare
    number = max(sum(taxels.values()), MIN_COVER_TAXELS) if several else scene.cover.taxels
    links = tuple(taxels) if several else scene.cover.links or tuple(taxels)
    return replace(scene.cover, links=(*links, *gridded), taxels=number, bare=())


def _same_cover(first: CoverSpec, second: CoverSpec) -> bool:
    """Whether two covers are equal, in any order of their links."""
    return replace(first, links=()) == replace(second, links=()) and {*first.links} == {*second.links}


def _rebased(choice: CoverSpec, before: CoverSpec, after: CoverSpec) -> CoverSpec:
    """Return ``after`` with what ``choice`` changes in ``before``."""
    first = asdict(before)
    changes = {name: value for name, value in asdict(choice).items() if value != first[name]}
    kept = [link for link in after.links if link in choice.links or link not in before.links]
    added = [link for link in choice.links if link not in before.links and link not in kept]
    return replace(after, **{**changes, "links": (*kept, *added)})


def _area(robot: Robot, link: str) -> float:
    """Return the area of the hull of a link [m²]; 0 without a shape."""
    mesh = robot.link(link).mesh
    return 0.0 if mesh is None else hull_area(mesh)


def _same_robot(one: Robot, other: Robot) -> bool:
    return one is other or (
        one.mjcf == other.mjcf and one.assets.keys() == other.assets.keys() and np.array_equal(one.home, other.home)
    )


def _fill(menu: QMenu, links: Iterable[str], run: Callable[[str], None], otherwise: str) -> None:
    menu.clear()
    for link in links:
        add_entry(menu, link.replace("_", " "), partial(run, link), objectName=f"{menu.objectName()}-{link}")
    if menu.isEmpty():
        menu.addAction(otherwise.rstrip(".")).setEnabled(False)

"""Links as coarse as the picture can show: by zoom and resolution, back to their own near the eye, alike to the eye."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.robots.load import robot_of_mesh
from tactile_maps.scene.scene_file import scene_for_taxels
from tactile_maps.session.link_levels import LinkLevels
from tactile_maps.session.prepare import prepare
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.robot.actors.camera import Viewpoint, orbit, zoom
from tactile_widgets.views.robot.actors.link_actors import PIXELS, LinkActors
from tactile_widgets.views.robot.actors.robot_actors import RobotActors
from tests.support.touch import bar_map
from tests.widgets.support.robot_view_driver import PICTURE

ROWS = PICTURE[1]


@pytest.fixture(scope="module")
def levels(prepared):
    made = LinkLevels.make(prepared.robot)
    assert any(made.links), "the arm has links with triangles to spare"
    return made


def _picture(scene, *, detail):
    """(height, width, 3) of the scene, with links as coarse as a picture of so many rows may have them."""
    scene.fit_depth()
    scene.fit_detail(detail)
    scene.plotter.render_window.Render()
    return scene.plotter.screenshot(return_img=True).astype(int)


def _counts(scene):
    return [actor.mapper.GetInput().GetNumberOfCells() for _, actor in scene.links.placed]


@pytest.mark.long
def test_error_of_links_is_at_most_half_a_pixel(scene, levels):
    scene.set_link_levels(levels)
    start = scene.viewpoint
    for factor in (0.2, 0.5, 1.0, 3.0):
        scene.look(zoom(start, factor))
        scene.fit_detail(ROWS)
        view = scene.viewpoint
        for row, (number, _) in enumerate(scene.links.placed):
            mesh = scene.prepared.robot.links[number].mesh
            pose = scene.poses[number]
            depth = float(((mesh.vertices @ pose[:3, :3].T + pose[:3, 3] - view.eye) @ view.axes[2]).min())
            pixel = 2 * depth * np.tan(np.radians(view.view_angle) / 2) / ROWS
            level = int(scene.links.shown[row])
            error = levels.links[number][level - 1].error if level else 0.0
            assert error <= PIXELS * pixel


def test_links_are_finer_close_up_and_at_higher_resolution(scene, levels, prepared):
    own = _counts(scene)
    scene.set_link_levels(levels)
    assert _counts(scene) == own, "nothing coarse is shown before it is known to be fit"
    start = scene.viewpoint
    drawn = []
    for factor in (0.1, 0.5, 1.0, 40.0):
        scene.look(zoom(start, factor))
        scene.fit_detail(ROWS)
        drawn.append(sum(_counts(scene)))
    assert drawn == sorted(drawn)
    assert drawn[0] < 0.6 * sum(own)
    scene.look(start)
    scene.fit_detail(ROWS)
    few = sum(_counts(scene))
    scene.fit_detail(100 * ROWS)
    assert few < sum(_counts(scene)) == sum(own)


def test_link_around_the_camera_has_its_own_mesh(scene, levels):
    scene.set_link_levels(levels)
    row = int(np.argmax([len(levels.links[number]) for number, _ in scene.links.placed]))
    number, _ = scene.links.placed[row]
    middle = scene.prepared.robot.links[number].mesh.bounds.mean(axis=0)
    place = scene.poses[number][:3, :3] @ middle + scene.poses[number][:3, 3]
    view = scene.viewpoint
    scene.look(replace(view, eye=place, focus=place + 0.1 * view.axes[2]))
    scene.fit_detail(ROWS)
    assert scene.links.shown[row] == 0


@pytest.mark.long
@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=["dark", "light"])
def test_coarse_links_are_drawn_like_full_ones(scene, levels, theme):
    scene.set_theme(theme)
    scene.skin.link_actors.clear()  # the links alone, of which the skin hides most
    for _, actor in list(enumerate(scene.skin._plain)):
        actor.visibility = False
    start = scene.viewpoint
    for turn in range(4):
        scene.look(orbit(start, ROWS * 1.5 * turn / 4, 0, ROWS))
        scene.set_link_levels(None)
        full = _picture(scene, detail=ROWS)
        scene.set_link_levels(levels)
        coarse = _picture(scene, detail=ROWS)
        assert scene.links.shown.any()
        robot = (full != full[0, 0]).any(axis=2)
        apart = np.abs(full - coarse).max(axis=2)[robot]
        assert (apart > 32).mean() < 0.005
        assert apart.mean() < 2.5


def _plate_with_a_groove():
    """A plate of 0.3 m that has a groove of half a millimetre: smaller than a pixel, but steep."""
    x = np.unique(np.concatenate([np.linspace(-0.15, 0.15, 31), [-1.6e-3, -1.5e-3, 1.5e-3, 1.6e-3]]))
    y = np.linspace(-0.15, 0.15, 31)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    height = np.where(np.abs(grid[:, 0]) < 1.55e-3, -0.5e-3, 0.0)
    corner = np.arange(len(grid)).reshape(len(x), len(y))
    a, b, c, d = (corner[i : len(x) - 1 + i, j : len(y) - 1 + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(np.column_stack([grid, height]), faces)


def test_small_groove_does_not_shade_its_surroundings(plotter):
    robot = robot_of_mesh(_plate_with_a_groove(), name="plate", source="plate", link="plate")
    actors = LinkActors(plotter, robot, DARK)
    actors.set_levels(LinkLevels.make(robot))
    view = Viewpoint(np.array([0.0, 0.0, 1.0]), np.zeros(3), np.array([0.0, 1.0, 0.0]), 30.0)
    actors.choose(view, ROWS, np.eye(4)[None])
    assert actors.shown.any()
    shown = pv.wrap(actors.placed[0][1].mapper.GetInput())
    corners = np.asarray(shown.point_data["Normals"])[shown.regular_faces]
    large = np.asarray(shown.compute_cell_sizes()["Area"]) > 1e-4
    assert large.any()
    assert corners[large][:, :, 2].min() > 0.95


def test_levels_of_another_robot_are_ignored(scene, levels):
    own = _counts(scene)
    scene.set_link_levels(LinkLevels("another", levels.links))
    scene.fit_detail(1.0)
    assert _counts(scene) == own


def test_levels_are_kept_for_the_same_robot(scene, levels, prepared):
    scene.set_link_levels(levels)
    scene.show_prepared(prepared)
    scene.fit_detail(20.0)
    assert scene.links.shown.any()


def test_levels_keep_hidden_links_and_culling(plotter, scene, levels):
    hidden = frozenset({scene.links.placed[1][0]})
    scene.hide(hidden)
    scene.set_link_levels(levels)
    scene.fit_detail(20.0)
    assert not plotter.renderer.HasViewProp(scene.links.placed[1][1])
    solid = [scene.prepared.robot.links[number].mesh.is_solid for number, _ in scene.links.placed]
    assert [actor.prop.culling == "back" for _, actor in scene.links.placed] == solid


def test_body_of_a_skin_without_a_robot_never_shows_through_it(plotter, tmp_path):
    save_map(bar_map(), tmp_path / "bar.npz")
    scene = RobotActors(plotter, DARK, PressureScale())
    scene.show_prepared(prepare(scene_for_taxels(str(tmp_path / "bar.npz"))))
    view = scene.viewpoint
    pictures = []
    for angle in (0.0, 1e-5):
        scene.look(replace(view, eye=view.eye + [angle, 0.0, 0.0]))
        pictures.append(_picture(scene, detail=ROWS))
    for actor in scene.links.placed:
        actor[1].visibility = False
    skin = _picture(scene, detail=ROWS)
    assert (skin.min(axis=2) > 120).sum() > 1000, "the skin is light"
    for picture in pictures:
        assert (np.abs(picture - skin).max(axis=2) > 60).sum() < 10

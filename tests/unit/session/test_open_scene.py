"""A person's own scene file: what robot, controller and files know better is told with its line."""

from __future__ import annotations

import pytest

from app.errors import SceneError
from app.scene.scene_file import load_scene
from app.session.open_scene import open_scene


@pytest.mark.parametrize(("lines", "words"), [
    ("robot = 'armm'", "line 2, robot.*Did you mean arm"),
    ("robot = 'gone.urdf'", "line 2, robot.*no such file.*gone.urdf"),
    ("robot = 'arm'\ntaxel_file = 'gone.txt'", "line 3, taxel_file.*gone.txt"),
    ("robot = 'arm'\n[cover]\nlinks = [\n'hand',\n'wing']", "line 6, cover.links.*wing"),
    ("robot = 'arm'\n[control]\n\nstiff_ness = 3", "line 5, control.stiff_ness.*stiffness"),
    ("robot = 'arm'\n[control]\nlaw = 'magic'", "line 4, control.law.*magic"),
    ("robot = 'arm'\n[control]\nstiffness = 1e9", "line 4, control.stiffness"),
    ("robot = 'arm'\n[contacts]\nestimator = 'tikonov'", "line 4, contacts.estimator.*Did you mean tikhonov"),
    ("robot = 'arm'\n[contacts]\n\nthreshold = -1", "line 5, contacts.threshold.*Choose 1 to"),
    ("robot = 'arm'\n[contacts]\nthreshold_pa = 1", "line 4, contacts.threshold_pa.*Did you mean threshold"),
    ("robot = 'arm'\n[contacts]\nthreshold = [1]", "line 4, contacts.threshold.*a number or a word"),
    ("robot = 'arm'\n[[motion]]\nposture = {}\n[[motion]]\nposture = { elbow_ptch = 1 }",
     "line 6.*Did you mean elbow_pitch"),
    ("robot = 'arm'\n[[motion]]\nposture = { elbow_pitch = 9 }", "line 4, motion.posture.elbow_pitch.*-2.35 to 2.35"),
    ("robot = 'arm'\n[[objects]]\nname = 'm'\nkind = 'mesh'\nfile = 'gone.stl'",
     "line 6, objects.file.*no such file.*gone.stl"),
])  # fmt: skip
def test_a_mistake_has_its_line(tmp_path, lines, words):
    path = tmp_path / "own.toml"
    path.write_text(f"# my own\n{lines}\n")
    with pytest.raises(SceneError, match=f"own.toml, {words}"):
        open_scene(str(path))


def test_what_is_right_opens(tmp_path):
    assert open_scene("slide") == load_scene("slide")
    path = tmp_path / "own.toml"
    path.write_text("robot = 'arm'\n[control]\nstiffness = 9\n[[motion]]\nposture = { elbow_pitch = 1 }")
    assert open_scene(str(path)) == load_scene(str(path))

"""A scene made real: every part there, told as it goes, and stopped when asked."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from app.errors import TactileMapsError
from app.scene.objects import ObjectSpec
from app.scene.scene import Scene
from app.scene.scene_file import load_scene
from app.session.prepare import prepare
from app.session.session import Session
from app.skin.cover_spec import CoverSpec
from tests.touch import arm


def test_the_arm():
    prepared = arm()
    assert prepared.scene.name == "arm"
    assert len(prepared.robot.joints) == 7
    assert [patch.link for patch in prepared.skin.patches] == ["upper_arm", "forearm", "hand"]
    assert prepared.map.skin is prepared.skin
    assert len(prepared.skin) == 300


def test_objects_are_made_in_the_scenes_order():
    scene = load_scene("arm")
    specs = (ObjectSpec("floor", "plane"), ObjectSpec("ball", "sphere", size=(0.05,), mass=1.0))
    prepared = prepare(replace(scene, cover=CoverSpec(links=("hand",), taxels=20), objects=specs, stimuli=()))
    assert [body.spec for body in prepared.objects] == list(specs)
    assert prepared.objects[1].mesh.size == pytest.approx(0.1 * 3**0.5, rel=0.01)
    assert Session(prepared).frame.objects.shape == (2, 4, 4)


def test_it_crosses_processes():
    copy = pickle.loads(pickle.dumps(arm()))
    assert copy.scene == arm().scene
    assert np.array_equal(copy.map.taxel_points, arm().map.taxel_points)
    assert np.array_equal(Session(copy).tick().posture, Session(arm()).tick().posture)


def test_progress_rises_and_may_cancel():
    scene = load_scene("arm")
    scene = replace(scene, cover=replace(scene.cover, links=("hand",), taxels=30))
    told = []
    prepare(scene, progress=lambda text, done: told.append((text, done)))
    done = [fraction for _, fraction in told]
    assert done == sorted(done)
    assert (done[0], done[-1]) == (0.0, 1.0)
    assert all(text for text, _ in told)

    class StoppedError(Exception):
        """The person closed the window."""

    def stop(text, fraction):
        if fraction > 0.2:
            raise StoppedError

    with pytest.raises(StoppedError):
        prepare(scene, progress=stop)


@pytest.mark.parametrize("scene", [
    Scene(name="s", robot="no such robot"),
    Scene(name="s", robot="arm", cover=CoverSpec(links=("no such link",))),
    Scene(name="s", robot="arm", taxel_file="no such file.txt"),
    Scene(name="s", robot="arm", objects=(ObjectSpec("mug", "mesh", file="no such file.stl"),)),
])  # fmt: skip
def test_what_is_missing_is_named(scene):
    with pytest.raises(TactileMapsError, match="no such"):
        prepare(scene)

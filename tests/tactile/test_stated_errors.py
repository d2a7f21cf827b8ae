"""The contact model chosen for a scene never changes a required output by more than its stated error.

Errors are measured on the loads of each shipped scene with its own effects, against the most accurate model of each
output: the load's own force and centre, and the half-space's pressures at the depth of the taxels.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene, scene_names
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.skin.model.bare_surface import with_bare_points
from tactile_maps.studies.sweeps.needs import TOLERANCE, change_of, outputs_of
from tactile_maps.tactile.mechanics.contact_notes import NOTED_SHARE
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.models.stated_errors import STATED_ERRORS, StatedError, stated_error_text
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

SECONDS = 8.0
EVERY = 5
LEAST = 0.1
"""Duration of each scene [s], ticks between compared loads, and the smallest compared force [N]."""
ROUNDING = 1e-12
PRESSURES = {"pressure", "readings", "pressure_shape"}
SHIPPED = {name: load_scene(name) for name in scene_names()}
TOUCHING = [name for name, scene in SHIPPED.items() if scene.unattended.effects.skin != "off"]
QUICK = ("poke", "slide", "crowded")
SCENES = [pytest.param(name, marks=() if name in QUICK else pytest.mark.long) for name in TOUCHING]


def errors_of(scene: Scene) -> Iterator[StatedError]:
    """Run a scene that no one attends; yield the errors of its contact model for each load on the skin as a whole."""
    prepared = prepare_cached(scene)
    skin = with_bare_points(prepared.robot, prepared.skin)
    shaped = not PRESSURES.isdisjoint(scene.effective_outputs)
    models = [
        CONTACT_MODELS[name].build(skin, scene.layer, SensorEffects())
        for name in (scene.unattended.effects.skin, *(("half-space",) if shaped else ()))
    ]
    spacing = np.sqrt(np.mean(skin.areas))
    positions = skin.positions
    session = Session(prepared, effects=scene.unattended.effects)
    for tick in range(round(SECONDS / scene.tick)):
        frame = session.tick()
        if "readings" not in scene.effective_outputs:
            check_contacts(frame.pressures, skin.areas, frame.regions)
        for load in session._simulation.loads if tick % EVERY == 0 else ():
            forces, *reference = (model.pressures([load]) * skin.areas for model in models)
            if load.force < LEAST or any(model.notes for model in models):
                continue
            centre = forces @ positions / forces.sum()
            yield StatedError(
                force=forces.sum() / load.force - 1,
                centre=float(np.linalg.norm(centre - load.point) / spacing),
                pressure=0.5 * float(np.abs(forces - reference[-1]).sum()) / load.force if shaped else 0.0,
            )


def check_contacts(pressures, areas, regions) -> None:
    """Contacts lose no force but that of taxels below the threshold."""
    unread = np.setdiff1d(np.arange(len(areas)), np.concatenate([[], *(region.taxels for region in regions)]))
    assert (pressures[unread] < TOUCH_THRESHOLD).all()
    lost = pressures @ areas - sum(region.force for region in regions)
    assert lost <= pressures[unread] @ areas[unread] + 1e-9


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", SCENES)
def test_derived_contact_model_keeps_its_stated_errors(name):
    scene = load_scene(name)
    stated = STATED_ERRORS[scene.unattended.effects.skin]
    errors = list(errors_of(scene))
    assert len(errors) > 5
    off = np.array([error.force for error in errors])
    assert off.max() <= stated.force + ROUNDING
    assert off.min() >= -stated.force - NOTED_SHARE, "less only where a part below what is noted is on bare surface"
    assert np.median(np.abs(off)) <= stated.force + ROUNDING
    if "centre_of_pressure" in scene.effective_outputs:
        assert max(error.centre for error in errors) <= stated.centre
    if not PRESSURES.isdisjoint(scene.effective_outputs):
        assert max(error.pressure for error in errors) <= stated.pressure


DRIFTING = {"carry": 0.04}
"""Scenes whose posture no goal determines completely: both fingers of a grip control a force, none their middle."""


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in TOUCHING if "posture" in SHIPPED[name].effective_outputs])
def test_derived_contact_model_does_not_change_the_posture(name):
    """The error of a task that follows touch, against the most accurate model, or the most accurate one with shear."""
    scene = load_scene(name)
    prepared = prepare_cached(scene)
    best = "punch" if "shear" in scene.effective_outputs else "half-space"
    exact = replace(scene, overrides={**scene.overrides, "skin": best})
    own, other = (outputs_of(prepared, each, SECONDS)["posture"] for each in (scene, exact))
    assert change_of("posture", own, other) <= DRIFTING.get(name, TOLERANCE)


@pytest.mark.parametrize("model", [name for name in STATED_ERRORS if name in CONTACT_MODELS])
def test_cheaper_models_state_larger_errors_of_pressure(model):
    assert STATED_ERRORS[model].pressure >= STATED_ERRORS["half-space"].pressure
    assert STATED_ERRORS[model].centre >= STATED_ERRORS["punch"].centre
    assert STATED_ERRORS[model].force == 0


def test_every_contact_model_states_its_errors():
    assert set(STATED_ERRORS) == set(EFFECTS["skin"].choices) - {"off", "auto"}


def test_guide_states_the_same_errors():
    page = (Path(__file__).parents[2] / "assets" / "guide" / "touch.md").read_text(encoding="utf8")
    rows = re.findall(r"^\| `([\w-]+)` \| [^|]+ \| ([^|]+) \| ([\d.]+) \| ([\d.]+) % \|$", page, flags=re.M)
    reported = {
        name: StatedError(0.0 if force == "exact" else float(force.split()[0]) / 100, float(centre), float(share) / 100)
        for name, force, centre, share in rows
    }
    assert reported == dict(STATED_ERRORS)


def test_reasons_state_the_errors_of_the_outputs():
    row = next(row for row in load_scene("crowded").unattended.rows if row.name == "skin")
    assert row.why == "the output is the force alone, not its distribution (force exact)"
    row = next(row for row in load_scene("poke").unattended.rows if row.name == "skin")
    assert "centre within 0.45 taxel spacings" in row.why
    assert stated_error_text("foundation", ("force",)) == "force within 5 %"
    assert stated_error_text("mine", ("force",)) == ""

"""Plug-ins of an installed package work through the public interface; a faulty one is reported."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.cli.commands.inspect import REGISTRIES
from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.force_estimation.estimation import FORCE_ESTIMATORS
from tactile_maps.contacts.pipeline import ReadingSettings, read_contacts
from tactile_maps.control.controller_registry import CONTROLLERS, settings_from
from tactile_maps.core.errors import (
    LiveError,
    PluginError,
    SceneError,
    SimulationError,
    SkinError,
    TactileMapsError,
    UsageError,
)
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.plugins import broken_plugins
from tactile_maps.export.export import FORMATS, export_recording
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.methods import METHODS, find_method
from tactile_maps.live.readings.readings import SourceEndedError
from tactile_maps.live.sources.open import SOURCE_KINDS, open_source
from tactile_maps.recording.encoding.message_codecs import decode_input, encode_input
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.scene.effects import EFFECTS, Effects, effect_entry
from tactile_maps.scene.scene_file import scene_from_toml, scene_to_toml
from tactile_maps.session.inputs import ControlChanged, EffectsChanged
from tactile_maps.session.session import Session
from tactile_maps.skin.formats.identify import kind_of
from tactile_maps.skin.formats.import_skin import TaxelFile
from tactile_maps.skin.formats.taxel_files import TAXEL_FORMATS, read_taxels
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.poke import PokePressed
from tactile_maps.tactile.press import press_skin
from tactile_maps.tactile.sensors.sensor_chain import EFFECTS_OF_BODIES, SENSOR_STAGES
from tactile_maps.tactile.sensors.sensor_effects import SENSOR_KEYS
from tests.support.recordings import record, small_arm

PACKAGES = Path(__file__).parents[1] / "plugins"
ALL = (CONTACT_MODELS, METHODS, SENSOR_STAGES, CONTROLLERS, FORCE_ESTIMATORS, TAXEL_FORMATS, FORMATS, SOURCE_KINDS)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with both packages, installed as a person installs them, from here alone."""
    folder = tmp_path_factory.mktemp("site")
    sources = folder / "sources"  # building writes into the folder of the sources
    for name in ("example", "broken"):
        (sources / name).mkdir(parents=True)
        for file in (PACKAGES / name).glob("*.*"):
            (sources / name / file.name).write_bytes(file.read_bytes())
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check"]
    command = [sys.executable, "-m", "pip", "install", *options, "--target", str(folder / "installed")]
    subprocess.run([*command, str(sources / "example"), str(sources / "broken")], check=True, timeout=300)
    return folder / "installed"


@pytest.fixture
def installed(site, monkeypatch):
    monkeypatch.syspath_prepend(str(site))
    return site


def of_broken(registry) -> dict[str, str]:
    return {one.name: one.problem for one in registry.plugins() if one.problem is not None}


def test_registries_have_no_plugins_without_packages():
    assert all(registry.plugins() == () for registry in ALL)
    assert all(tuple(registry) == tuple(registry._built_in) for registry in ALL)


def test_every_registry_is_listed():
    assert [registry.kind for registry in ALL] == list(REGISTRIES)


def install(folder, name, entry_points):
    """A package that is nothing but what it states."""
    info = folder / f"{name}-2.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text(entry_points)


def test_plugin_is_imported_only_when_its_name_is_requested(tmp_path, monkeypatch):
    install(tmp_path, "lazy", "[tactile_maps.map_methods]\nlazily = lazily_imported:METHOD\n")
    source = "from tactile_maps.flattening.methods import Method\nMETHOD = Method('lazily', 'none', lambda *_: ())"
    (tmp_path / "lazily_imported.py").write_text(source)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert find_method("tutte").title
    assert "other" not in METHODS
    assert "lazily_imported" not in sys.modules
    assert "lazily" in METHODS
    assert "lazily_imported" in sys.modules


@pytest.mark.long
def test_plugin_method_flattens(installed):
    surface = small_arm().skin.patches[0].surface
    chart = flatten(surface, method="oblong")
    assert chart.method == "oblong"
    assert not chart.findings


def test_plugin_contact_model_is_a_choice_of_scenes(installed):
    skin = small_arm().skin
    pressures = press_skin(skin, skin.taxel_point(3), force=2.0, model="two-taxels")
    assert (pressures > 0).sum() == 2
    assert pressures @ skin.areas == pytest.approx(2.0)
    assert "two-taxels" in EFFECTS["skin"].choices
    assert EFFECTS["skin"].checked("two-taxels") == "two-taxels"
    with pytest.raises(SceneError, match=r"Did you mean two-taxels\?"):
        EFFECTS["skin"].checked("two-taxel")


def run(prepared, scene, ticks=60):
    """Frames of a scene on the small arm, with a finger from the start."""
    session = Session(replace(prepared, scene=scene), scripted=False)
    session.submit(PokePressed(1, prepared.skin.taxel_point(3)))
    return [session.tick() for _ in range(ticks)]


def test_plugin_sensor_stage_is_an_effect_of_scenes(installed):
    arm = small_arm()
    scene = replace(arm.scene, overrides={**arm.scene.overrides, "hum": {"pressure": 200.0}})
    assert scene_from_toml(scene_to_toml(scene), name="again").overrides["hum"] == {"pressure": 200.0}
    assert [row.why for row in scene.decision.rows if row.name == "hum"] == [
        "set by the scene (pressure 200, hertz 50)"
    ]
    input_ = EffectsChanged(scene.effects)
    assert decode_input(encode_input(3, input_, arm.map), arm.map) == (3, input_)
    quiet, humming = ([frame.pressures for frame in run(arm, one, 12)] for one in (arm.scene, scene))
    heard = np.array([with_it - without for without, with_it in zip(quiet, humming, strict=True)])
    assert np.ptp(heard, axis=1).max() < 1e-9, "all taxels alike"
    assert np.abs(heard).max() == pytest.approx(200.0)
    assert heard[2:] == pytest.approx(-heard[:-2], abs=1e-6), "50 Hz at 200 readings a second"
    said = SensorUncertainty.of_sensor(scene.effects.sensor)
    assert said.noise == pytest.approx(200.0 / np.sqrt(2)), "its error is in thresholds and error bars"
    with pytest.raises(SceneError, match=r"effects\.hum\.pressure.*20000"):
        EFFECTS["hum"].checked({"pressure": 2e4})
    with pytest.raises(SceneError, match=r"Did you mean hum\?.*plug-in"):
        effect_entry("hun")


def test_no_stage_has_the_name_of_another_effect():
    assert set(EFFECTS_OF_BODIES) == set(EFFECTS) - set(SENSOR_KEYS)


@pytest.mark.parametrize("controller", ["slack", "gentle"])
def test_plugin_controller_is_a_choice_of_scenes(installed, controller):
    arm = small_arm()
    scene = replace(arm.scene, control={"controller": controller})
    assert scene_from_toml(scene_to_toml(scene), name="again").control == {"controller": controller}
    frames = run(arm, scene)
    assert all(np.isfinite(frame.posture).all() for frame in frames)
    assert (frames[-1].task is None) == (controller == "slack")
    moved = ControlChanged(settings_from(scene.control))
    assert decode_input(encode_input(3, moved, arm.map), arm.map) == (3, moved)
    with pytest.raises(SceneError, match=r"Did you mean slack\?"):
        settings_from({"controller": "slak"})


def test_plugin_estimator_reads_contacts(installed):
    arm = small_arm()
    pressures = press_skin(arm.skin, arm.skin.taxel_point(3), force=9.0)
    (usual,), (found,) = (read_contacts(arm.map, pressures, estimator=name) for name in ("area-sum", "calibrated-sum"))
    assert found.force == pytest.approx(1.1 * usual.force)


def test_plugin_format_is_imported(installed, tmp_path):
    path = tmp_path / "pad.xyz"
    x, y = np.meshgrid(np.arange(5), np.arange(4))
    np.savetxt(path, np.stack([3 * x.ravel(), 3 * y.ravel(), np.zeros(20)], axis=1))
    assert kind_of(path) is FileKind.TAXELS
    assert len(TaxelFile(path).skin()) == 20


def test_plugin_format_recognises_its_content_among_files_of_a_shared_suffix(installed, tmp_path):
    path = tmp_path / "pad.json"
    path.write_text('{"comb_mm": [0, 3, 6]}')
    assert read_taxels(path).positions.tolist() == [[0, 0, 0], [0.003, 0, 0], [0.006, 0, 0]]
    path.write_text('{"skin": 1}')
    with pytest.raises(SkinError, match="skin: an object is missing"):
        read_taxels(path)


def test_plugin_exports_a_recording_and_can_be_cancelled(installed, tmp_path):
    record(small_arm(), tmp_path / "demo.mcap", ticks=20)
    export_recording(tmp_path / "demo.mcap", tmp_path / "out.peaks", to="peaks")
    assert len((tmp_path / "out.peaks").read_text().splitlines()) == 20

    class CancelledError(Exception):
        pass

    def cancel(_text, _share):
        raise CancelledError

    with pytest.raises(CancelledError):
        export_recording(tmp_path / "demo.mcap", tmp_path / "other.peaks", to="peaks", progress=cancel)
    assert not (tmp_path / "other.peaks").exists()


def test_plugin_source_is_read(installed):
    source = open_source("sine:7")
    source.open()
    assert len(source.receive(0.0).values) == 7
    assert all(source.receive(0.0) is not None for _ in range(9))
    with pytest.raises(SourceEndedError):
        source.receive(0.0)
    with pytest.raises(PluginError, match=r"plug-in sine of tactile-maps-example 1\.0\.0: it failed with ValueError"):
        open_source("sine:many")
    with pytest.raises(UsageError, match=r"sine:"):
        open_source("sinus:7")


def test_failing_plugin_source_raises_live_error(installed, monkeypatch):
    source = open_source("sine:7")
    monkeypatch.setattr(sys.modules["tactile_maps_example"].Sine, "receive", lambda self, timeout: 1 / 0)
    with pytest.raises(LiveError, match="ZeroDivisionError"):
        source.receive(0.0)


def test_invalid_plugins_are_omitted_with_their_reason(installed):
    assert of_broken(METHODS) == {
        "no-module": "ModuleNotFoundError: No module named 'tactile_maps_broken_is_not_there'",
        "tutte": "its name is that of a built-in one",
        "wrong-call": "its function does not take (disk, lengths): too many positional arguments",
        "wrong-kind": "tactile_maps_broken:WRONG_KIND is no Method but a dict",
    }
    assert of_broken(TAXEL_FORMATS) == {
        "taken": "its suffix .csv is that of a built-in format, so that it needs recognises"
    }
    assert of_broken(SENSOR_STAGES) == {
        "noise": "its name is that of a built-in one",
        "ill-noise": "its noise is not a standard deviation",
        "nowhere": "unknown effect in before: bus (choose one of: crosstalk, hysteresis, gain_spread, offset_drift, "
        "noise, saturation, threshold, quantisation, dead_taxels, sampling)",
    }
    assert of_broken(CONTROLLERS) == {"no-setting": "it uses unknown settings: colour"}
    assert of_broken(FORCE_ESTIMATORS) == {"raises": "SystemExit: not today"}
    assert not {"no-module", "wrong-call", "wrong-kind"} & set(METHODS)
    assert METHODS["tutte"].title == "nothing but validity"
    assert {plugin.package for plugin in broken_plugins()} == {"tactile-maps-broken"}
    with pytest.raises(SceneError, match=r"tactile-maps-broken that adds it was left out: SystemExit: not today"):
        ReadingSettings("raises")


def test_error_of_a_plugin_names_it(installed):
    arm = small_arm()
    surface = arm.skin.patches[0].surface
    with pytest.raises(PluginError, match=r"plug-in failing of tactile-maps-broken 0\.1.*ZeroDivisionError.*uninstall"):
        flatten(surface, method="failing")
    with pytest.raises(PluginError, match="did not return finite vertex positions"):
        flatten(surface, method="short")
    for change, problem in (
        ({"overrides": {"deaf": "on"}}, r"plug-in deaf.*did not return a finite reading for each taxel"),
        ({"control": {"controller": "runaway"}}, r"plug-in runaway.*no finite posture for each joint"),
    ):
        with pytest.raises(TactileMapsError, match=problem):
            run(arm, replace(arm.scene, **change), 1)
    with pytest.raises(PluginError, match="its object has no notes, pressures"):
        press_skin(arm.skin, arm.skin.taxel_point(0), force=1.0, model="empty-handed")


def test_two_packages_with_the_same_name_are_both_omitted(installed, tmp_path, monkeypatch):
    assert "oblong" in METHODS
    install(tmp_path, "other", "[tactile_maps.map_methods]\noblong = other_module:METHOD\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert "oblong" not in METHODS
    assert of_broken(METHODS)["oblong"] == "two packages have plug-ins of this name"


@pytest.mark.parametrize("change", ["model", "estimator"])
def test_recording_names_a_plugin_that_is_not_installed(site, tmp_path, monkeypatch, change):
    path = tmp_path / "demo.mcap"
    with monkeypatch.context() as here:
        here.syspath_prepend(str(site))
        arm = small_arm()
        overrides = {**arm.scene.overrides, "skin": "two-taxels"} if change == "model" else arm.scene.overrides
        reading = {"estimator": "calibrated-sum"} if change == "estimator" else {}
        record(replace(arm, scene=replace(arm.scene, overrides=overrides, reading=reading)), path, ticks=5)
        assert len(RecordingPlayer(path)) == 5
    name = "two-taxels" if change == "model" else "calibrated-sum"
    with pytest.raises(Exception, match=f"found: {name}.*install the plug-in") as caught:
        list(RecordingPlayer(path))
    assert type(caught.value).__name__ in ("SceneError", "RecordingError")


def test_effects_of_missing_plugin_are_rejected():
    with pytest.raises(SceneError, match="install the plug-in that adds it"):
        Effects(skin="two-taxels")


def test_session_keeps_its_last_frame_when_a_plugin_fails(installed, monkeypatch):
    arm = small_arm()
    scene = replace(arm.scene, overrides={**arm.scene.overrides, "skin": "two-taxels"})
    session = Session(replace(arm, scene=scene))
    good = session.tick()
    monkeypatch.setattr(sys.modules["tactile_maps_example"].TwoTaxels, "pressures", lambda self, loads: 1 / 0)
    for _ in range(2):
        with pytest.raises(SimulationError, match=r"plug-in two-taxels.*ZeroDivisionError"):
            session.tick()
    assert session.failure is not None
    assert session.frame is good
    monkeypatch.undo()

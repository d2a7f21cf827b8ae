"""An option that has no effect is refused, by name, with the reason; nothing is done before."""

from __future__ import annotations

import argparse

import pytest

from tactile_maps.cli.parser import build_parser
from tactile_maps.cli.shared.unused_options import NEEDED, REPLACED
from tactile_maps.maps.formats.map_file import save_map
from tactile_widgets.__main__ import main
from tests.support.touch import bar_map


@pytest.fixture
def files(tmp_path):
    """Files by ending, and a table of taxels; only the skin has content."""
    found = {ending: tmp_path / f"it.{ending}" for ending in ("csv", "mcap", "stl", "toml", "npz")}
    for path in found.values():
        path.write_text("time,1\n0,0\n")
    found["taxels"] = tmp_path / "taxels.csv"
    found["taxels"].write_text("x,y,z\n0,0,0\n")
    save_map(bar_map(), found["npz"], overwrite=True)
    return {ending: str(path) for ending, path in found.items()}


def options() -> dict[str, set[str]]:
    """Options by command."""
    (action,) = [one for one in build_parser()._actions if isinstance(one, argparse._SubParsersAction)]
    return {
        command: {name for one in parser._actions for name in one.option_strings}
        for command, parser in action.choices.items()
    }


@pytest.mark.parametrize("rules", [NEEDED, REPLACED])
def test_every_named_option_exists(rules):
    known = options()
    for command, rows in rules.items():
        for option, others in rows.items():
            assert {option, *others} <= known[command], command


@pytest.mark.parametrize(
    ("words", "output"),
    [
        ("run --port 8765", "--port: this option has no effect without --serve. Add --serve, or remove --port"),
        ("run --host 127.0.0.1", "--host: this option has no effect without --serve"),
        ("run --no-viewers", "--no-viewers: this option has no effect without --output"),
        ("run --overwrite", "--overwrite: this option has no effect without --output"),
        ("listen udp: --max-speed 0.2", "--max-speed: this option has no effect without --send"),
        ("listen udp: --save-calibration g.csv", "--save-calibration: this option has no effect without --weight"),
        ("listen udp: --overwrite", "without --output or --save-calibration"),
        (
            "listen udp: --speed 2",
            "--speed: this option has no effect with this source (found: udp:). It sets how fast a",
        ),
        (
            "listen serial:///dev/ttyS0 --mapping {toml}",
            "--mapping: this option has no effect with this source (found: se",
        ),
        ("listen ros2:{toml} --mapping {toml}", "--mapping: this option has no effect with this source (found: ros2:"),
        (
            "listen {csv} --mapping {toml}",
            "--mapping: this option has no effect with this source (found: {csv}). It names",
        ),
        ("listen {csv} --token 12345678", "--token: this option has no effect with this source (found: {csv}). It is"),
        ("listen {csv} --token-file {csv}", "--token-file: this option has no effect with this source"),
        ("listen yarp://127.0.0.1:1 --token 12345678", "--token: this option has no effect with this source"),
        (
            "listen udp: --token 12345678 --remote",
            "--remote: this option has no effect with this source (found: udp:). It",
        ),
        ("listen zmq://192.0.2.1 --token 12345678 --remote", "--remote: this option has no effect with this source"),
        ("listen {csv} --remote", "--remote: this option has no effect with this source"),
        (
            "listen {csv} --remote --send udp://127.0.0.1:9 --controller hybrid",
            "--remote: this option has no effect with",
        ),
        ("listen {csv} --skin {npz} --link forearm", "--link: this option has no effect with this skin (found: {npz})"),
        ("screenshot -o x.png --dpi 300", "--dpi: this option has no effect without --figure"),
        ("screenshot -o x.png --figure map --theme dark", "--theme: this option has no effect next to --figure"),
        ("screenshot -o x.png --figure map --size 800x600", "--size: this option has no effect next to --figure"),
        ("inspect {stl} --costs", "--costs: this option has no effect with this input (found: {stl}). It measures"),
        ("inspect --plugins --costs", "--costs: this option has no effect next to --plugins"),
        ("inspect --plugins --report x.html", "--report: this option has no effect next to --plugins"),
        ("inspect arm --overwrite", "--overwrite: this option has no effect without --report"),
        ("weigh --overwrite", "--overwrite: this option has no effect without --report"),
        ("replay {mcap} --overwrite", "--overwrite: this option has no effect without --stimuli"),
        ("compare slide --controllers qp --overwrite", "--overwrite: this option has no effect without --output"),
        ("trim {mcap} -o out --episodes --from 0", "--from: this option has no effect next to --episodes"),
        (
            "export {mcap} -o out --to csv --image-width 64",
            "--image-width: this option has no effect with this format (",
        ),
        ("export {mcap} -o out --to npz --rate 25", "--rate: this option has no effect with this format (found: npz)"),
        ("map {stl} --overwrite", "--overwrite: this option has no effect without --output"),
        ("map {stl} --touches 3000", "--touches: this option has no effect without --learn"),
        ("map {stl} --babble unbiased", "--babble: this option has no effect without --learn"),
        ("map {stl} --pitch 5 --taxels 1000", "--taxels: this option has no effect next to --pitch"),
        ("map {stl} --grid 2x2 --from 0,0,0 --to 1,1,1 --pitch 2", "--pitch: this option has no effect next to --grid"),
        (
            "map {stl} --grid 2x2 --from 0,0,0 --to 1,1,1 --surface outer",
            "--surface: this option has no effect next to",
        ),
        ("map {stl} --uv x.obj --method tutte", "--method: this option has no effect next to --uv"),
        ("map {stl} --learn isomap --cut 2", "--cut: this option has no effect next to --learn"),
        ("map {stl} --learn isomap --uv x.obj", "--uv: this option has no effect next to --learn"),
        (
            "map {stl} --method tutte --lengths 1",
            "--lengths: this option has no effect with this method (found: tutte)",
        ),
        ("map {stl} --fix-modules", "--fix-modules: this option has no effect without --compare"),
        ("map {stl} --compare x.npz --fix-modules", "--fix-modules: this option has no effect with this file ("),
        ("map {stl} --links hand", "--links: this option has no effect with this input (found: {stl})"),
        (
            "map {stl} --robot icub",
            "--robot: this option has no effect with this input (found: {stl}). It names the robot",
        ),
        ("map {stl} --robot none", "It names the robot that carries taxels, or none, and this file has no taxels"),
        (
            "map arm --surface all",
            "--surface: this option has no effect with this input (found: arm). It is for meshes",
        ),
        (
            "map {taxels} --taxels 1000",
            "--taxels: this option has no effect with this input (found: {taxels}). It places taxels",
        ),
        ("map {taxels} --surface outer", "--surface: this option has no effect with this input"),
        (
            "map {npz} --links bar",
            "--links: this option has no effect with this input (found: {npz}). It chooses links",
        ),
        (
            "map {mcap} --learn isomap --touches 100",
            "--touches: this option has no effect with this input (found: {mcap}",
        ),
        (
            "inspect {npz} --home elbow_pitch=1",
            "--home: this option has no effect with this input (found: {npz}). It is",
        ),
        (
            "compare {mcap} --controllers qp --home a=1",
            "--home: this option has no effect with this input (found: {mcap})",
        ),
        ("map {mcap} --home a=1", "--home: this option has no effect with this input (found: {mcap})"),
        (
            "map {mcap} --links hand",
            "--links: this option has no effect with this input (found: {mcap}). A recording has",
        ),
    ],
)
def test_option_without_effect_is_rejected(words, output, files, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert main(words.format(**files).split()) == 2
    message = capsys.readouterr().err
    assert output.format(**files) in message
    assert sorted(tmp_path.iterdir()) == before

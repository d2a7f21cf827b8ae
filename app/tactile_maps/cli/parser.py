"""Commands and options of the command line."""

from __future__ import annotations

import argparse
import math
import os
import re
import shlex
import sys
from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import version
from typing import Any, TypeAlias, TypeVar

from tactile_maps.cli.shared.output import write_error, write_output
from tactile_maps.studies.catalogue import STUDY_NAMES

EXPORT_FORMATS = ("csv", "parquet", "npz", "hdf5", "lerobot", "rosbag2", "mp4", "rerun")
"""Formats of ``tactile_maps.export.export``, which is not imported to parse a command line."""
EPILOG = """exit codes: 0 done, 1 failed with a message, 2 bad usage,
            130 Ctrl-C, 143 SIGTERM, 129 SIGHUP or a closed terminal, 131 SIGQUIT
robots: arm, two_arms, hand (ours); ur5e, icub, icub_whole (pip install 'tactile-maps[robots]'); a file;
        a model in MENAGERIE_ROOT or known to mujoco-menagerie"""

EXAMPLES: Mapping[str, str] = {
    "gui": "gui slide.mcap",
    "run": "run slide --for 10 -o slide.mcap",
    "listen": "listen udp://127.0.0.1:9000 --skin hand.csv --robot none --tare 50 -o skin.mcap",
    "check": "check udp://127.0.0.1:9000 --skin hand.csv --robot none --report check.html",
    "screenshot": "screenshot --scene slide --at 3 -o slide.png",
    "film": "film slide.mcap -o slide.mp4",
    "map": "map ur5e --links forearm_link --taxels 500 -o forearm.npz",
    "inspect": "inspect ur5e",
    "weigh": "weigh ur5e --mass 0.2",
    "calibrate": "calibrate loads.csv --skin hand.csv --robot none -o calibration.csv",
    "place": "place hand.csv --robot ur5e -o placed.csv",
    "budget": "budget slide --milliseconds 5",
    "replay": "replay slide.mcap --verify",
    "recover": "recover broken.mcap -o fixed.mcap",
    "trim": "trim slide.mcap --from 1 --to 3 -o part.mcap",
    "export": "export slide.mcap --to csv -o slide",
    "compare": "compare follow_path --controllers hybrid,qp --for 5",
    "study": "study needs --quick -o studies",
    "guide": "guide control",
    "desktop": "desktop",
    "cache": "cache",
}
"""Example of each command, which its help shows."""

_UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_THEMES = ("dark", "light")
_RECORDING = "FILE.mcap"
Value = TypeVar("Value")


class _NotedAction(argparse.Action):
    """Stores a value, or its constant for a flag, and adds the names of the option to ``given``.

    Without ``given`` an option whose value equals its default would count as left out.
    """

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        setattr(namespace, self.dest, self.const if self.nargs == 0 else values)
        namespace.given = frozenset(self.option_strings) | getattr(namespace, "given", frozenset())


_ACTIONS: Mapping[str | None, Callable[..., argparse.Action]] = {
    None: _NotedAction,
    "store_true": partial(_NotedAction, nargs=0, const=True, default=False),
    "store_false": partial(_NotedAction, nargs=0, const=False, default=True),
}


class _Parser(argparse.ArgumentParser):
    """A parser that notes which options are given, and reports a help text that cannot be written.

    The base class ignores errors while it writes.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        for name, action in _ACTIONS.items():
            self.register("action", name, action)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.dest == "command" and value not in (action.choices or ()) and os.path.exists(value):
            remedy = f"To open it: tactile-maps gui {shlex.quote(value)}"
            raise argparse.ArgumentError(action, f"this is a file, not a command (found: {value}). {remedy}")
        super()._check_value(action, value)

    def _print_message(self, message: str, file: object = None) -> None:
        if file is sys.stdout:
            write_output(message)
        else:
            write_error(message)


_Add: TypeAlias = Callable[..., _Parser]
"""Adds the parser of a command."""


def build_parser() -> argparse.ArgumentParser:
    """Return the parser; its ``command`` is empty for the window."""
    parser = _Parser(
        prog="tactile-maps",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Tactile maps of robot skin: simulate, control contact, record and measure.",
    )
    parser.add_argument("--version", action="version", version=f"tactile-maps {version('tactile-maps')}")
    _scene_options(parser)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for add_command in _COMMANDS:
        add_command(partial(_with_help, commands.add_parser))
    return parser


def _with_help(add_parser: _Add, name: str, *, help: str) -> _Parser:
    """Add the parser of a command whose own help begins with its description and ends with an example."""
    return add_parser(
        name,
        help=help,
        description=f"{help[0].upper()}{help[1:]}.",
        epilog=f"example: tactile-maps {EXAMPLES[name]}",
    )


def _add_gui(command: _Add) -> None:
    gui = command("gui", help="open the window (the default)")
    gui.add_argument("file", nargs="?", metavar="FILE", help="scene, robot, mesh, skin, recording or map to open")
    _scene_options(gui)
    gui.add_argument("--json", action="store_true", help="report a failure as one JSON object")


def _add_run(command: _Add) -> None:
    run = command("run", help="simulate, and record, without a window")
    add = run.add_argument
    add("scene_file", nargs="?", metavar="SCENE", help="name or file of a scene")
    _scene_options(run)
    seconds = "simulated seconds (default 5, or those of the sweep)"
    add("--for", dest="seconds", type=_positive, metavar="SECONDS", help=seconds)
    add("--stimuli", metavar="FILE.toml", help="stimulus script to play instead of the scene's")
    _output(run, folder="sweep", metavar="FILE.mcap|DIR", help="record to this file; a folder with --sweep")
    add("--sweep", metavar="FILE.toml", help="record many variations of the scene, with an index of them")
    _resume_options(
        run, "with --sweep: record the missing variations", "replace an existing file, or with --sweep all recordings"
    )
    _workers(run, "with --sweep: number of parallel recordings, 0 for one per core")
    viewers = "omit the messages for Foxglove, Lichtblick and Rerun: a third of the size; replays are the same"
    add("--no-viewers", dest="viewers", action="store_false", help=viewers)
    serve = "send to Foxglove and Lichtblick, in real time, on this computer only"
    add("--serve", action="store_true", help=serve)
    rerun = "send to an open Rerun viewer, in real time (default: on this computer)"
    add("--rerun", nargs="?", const="rerun+http://127.0.0.1:9876/proxy", metavar="ADDRESS", help=rerun)
    add("--port", type=_port, default=8765, help="port of --serve (default 8765; 0 for any free port)")
    host = "address of --serve; 0.0.0.0 lets other computers watch"
    add("--host", default="127.0.0.1", metavar="ADDRESS", help=host)
    _json(run)


def _add_listen(command: _Add) -> None:
    listen = command("listen", help="receive readings of a real skin: show statistics and contacts, and record")
    add = listen.add_argument
    add("source", metavar="SOURCE", help="udp:, zmq:, serial:, yarp: or ros2: address, or a file")
    _scene_options(listen)
    _output(listen, metavar=_RECORDING, help="record to this file")
    _overwrite(listen, "replace existing files")
    add("--for", dest="seconds", type=_positive, metavar="SECONDS", help="duration (default: until Ctrl-C)")
    add("--calibration", metavar="FILE", help="gain and offset of each taxel (.csv, .toml)")
    add("--inverted", action="store_true", help="the values fall under pressure: use a negative gain")
    add("--mode", choices=("raw", "baseline", "kPa"), help="values from which contacts are read (default: best known)")
    tare = "use the first N readings as those of the untouched skin (5 or more; 50 recommended)"
    add("--tare", type=_integer, metavar="N", help=tare)
    level = "smallest value of a taxel in contact, in the unit shown: counts or kPa (default: from the tare)"
    add("--threshold", type=_threshold, metavar="VALUE", help=level)
    close = "after a tare: separate contacts whose taxels are connected by the dip between them (default), or join them"
    add("--close-contacts", choices=("separate", "joined"), help=close)
    add("--weight", type=_positive, metavar="KG", help="calibrate with this mass, which is on the skin at the end")
    seconds = "averaging time at the end (default 0.5); rejected while the sum still changes by 5 %%"
    add("--weight-seconds", type=_positive, metavar="SECONDS", help=seconds)
    _output(listen, "--save-calibration", metavar="FILE.csv", help="write the calibration found with --weight")
    add("--controller", metavar="NAME", help="show the motion that this controller requests of the robot")
    send = "send the motion of --controller to udp://HOST:PORT or zmq://HOST:PORT: the robot may move"
    stop = "a safety stop ends sending but not listening, and the exit code is still 0"
    add("--send", metavar="ADDRESS", help=f"{send}; {stop}")
    speed = "with --send: speed limit of every joint (default 0.2); those of the robot's model apply as well"
    add("--max-speed", type=float, metavar="RAD/S", help=speed)
    add("--max-force", type=float, metavar="N", help="with --send: a stronger contact ends sending (default 15)")
    anyway = "with --send: also after a doubtful tare, which may hide contacts; the default ends with exit code 1"
    add("--send-anyway", action="store_true", help=anyway)
    needed = "token required in every packet; udp: and zmq: need one with --send or --remote"
    _source_options(listen, needed, "receive from other machines, which needs a token, and send to them")
    _json(listen)


def _add_check(command: _Add) -> None:
    check = command("check", help="guided check of a real skin: press its modules, and get a report of faulty channels")
    add = check.add_argument
    add("source", metavar="SOURCE", help="udp:, zmq:, serial:, yarp: or ros2: address, or a file")
    _scene_options(check)
    order = "modules in the requested order (default of a live skin), or any touches of a file (its default)"
    add("--order", choices=("asked", "any"), help=order)
    _report(check)
    add("--rest", type=_positive, metavar="SECONDS", help="time without touch at the start (default 2)")
    add("--patience", type=_positive, metavar="SECONDS", help="leave a module that is not felt after this time (20)")
    add("--pause", type=_positive, metavar="SECONDS", help="leave a module felt in part after this time (2)")
    level = "smallest change that counts as felt, in the unit of the readings (default 1; six deviations of the noise)"
    add("--threshold", type=_threshold, metavar="VALUE", help=level)
    _source_options(check, "token required in every packet", "receive from other machines, which needs a token")
    _json(check)


def _add_screenshot(command: _Add) -> None:
    shot = command("screenshot", help="picture of the whole window, without a display")
    add = shot.add_argument
    _scene_options(shot)
    add("--at", type=_not_negative, default=2.0, metavar="SECONDS", help="simulated seconds (default 2)")
    add("--theme", choices=_THEMES, default="dark")
    add("--size", type=_size, default=(1400, 900), metavar="WxH", help="size in pixels (default 1400x900)")
    _output(shot, required=True, metavar="FILE", help=".png; for a figure also .svg or .pdf")
    _overwrite(shot)
    figure = "figure for a paper of robot, map or both, instead of the window"
    add("--figure", choices=("views", "robot", "map"), help=figure)
    add("--mm", type=_millimetres, default=(170.0, 85.0), metavar="WxH", help="size of a figure (default 170x85)")
    add("--dpi", type=_integer, default=300, help="resolution of a figure (default 300)")
    colours = "colours of a figure (default paper)"
    add("--colours", choices=("paper", "light", "dark"), default="paper", help=colours)
    _json(shot)


def _add_film(command: _Add) -> None:
    film = _recording_command(command, "film", "film of body and map of a recording, without a display")
    add = film.add_argument
    _output(film, required=True, metavar="FILE.mp4")
    _overwrite(film)
    add("--size", type=_size, default=(1280, 640), metavar="WxH", help="size in pixels (default 1280x640)")
    add("--rate", type=_positive, default=25.0, metavar="HZ", help="pictures per second (default 25)")
    add("--from", dest="first", type=_not_negative, metavar="SECONDS", help="start (default 0)")
    add("--to", dest="last", type=_positive, metavar="SECONDS", help="end (default: end of the recording)")
    add("--theme", choices=_THEMES, default="dark")
    _json(film)


def _add_map(command: _Add) -> None:
    make = command("map", help="robot, mesh, taxel or skin file -> tactile map and its quality")
    source = "robot, mesh, taxel file (.txt .csv .json .npz, URDF sensors), skin, map, recording"
    make.add_argument("input", metavar="INPUT", help=source)
    target = ".npz (everything), .obj (with UV), .svg, .png, .json (Genoa), .csv, .xml (MuJoCo)"
    _output(make, metavar="FILE", help=target)
    _overwrite(make)
    make.add_argument("--seed", type=_seed, default=0)
    _json(make)
    _skin_options(make)
    _flattening_options(make)
    _learning_options(make)
    _comparison_options(make)


def _skin_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of covered links and of the placement of taxels."""
    add = parser.add_argument_group("skin").add_argument
    add("--links", nargs="+", default=[], metavar="LINK", help="links to cover, or the link that carries the taxels")
    robot = "robot that carries the taxels of a file (default: icub for .txt); 'none' without"
    add("--robot", metavar="NAME", help=robot)
    surface = "part of a mesh to cover (default outer)"
    add("--surface", default="outer", choices=("outer", "all", "cover"), help=surface)
    add("--taxels", type=_integer, default=1000, help="number of taxels to place (default 1000)")
    add("--pitch", type=float, metavar="MM", help="distance between taxels, instead of their number")
    pattern = "pattern of the taxels (default even)"
    add("--pattern", default="even", choices=("even", "hexagonal", "modules"), help=pattern)
    add("--grid", type=_grid, metavar="ROWSxCOLUMNS", help="a grid of taxels instead, on the link named by --links")
    add("--from", dest="first", type=_corner, metavar="X,Y,Z", help="first corner of the grid, link frame [mm]")
    add("--to", dest="last", type=_corner, metavar="X,Y,Z", help="last corner of the grid [mm]")
    mirrored = "the second of the two grids with these corners, or the first (default: the flatter one)"
    add("--mirrored", action=argparse.BooleanOptionalAction, help=mirrored)
    add("--density", choices=("curvature",), help="more taxels where curvature is high")
    axes = "1: pressure (default), 3: pressure and shear"
    add("--axes", type=_integer, default=1, choices=(1, 3), help=axes)
    add("--keep-border", type=float, metavar="MM", help="no taxels within this distance of a border")
    _robot_options(parser)


def _flattening_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of flattening, or of an imported map."""
    add = parser.add_argument_group("flattening").add_argument
    add("--method", default="symmetric-dirichlet", help="symmetric-dirichlet (default), tutte, harmonic, lscm, ...")
    add("--lengths", type=float, default=1.0, metavar="0-1", help="preserve lengths (1, default) or angles (0)")
    cut = "extra seams per patch (default: automatic)"
    add("--cut", "--seams", dest="seams", type=_integer, metavar="N", help=cut)
    add("--uv", metavar="FILE.obj", help="use the map of this unwrapped OBJ instead of flattening")


def _learning_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of learning a map from touch."""
    add = parser.add_argument_group("learning from touch").add_argument
    learn = "learn the map from tactile readings: information-distance, geodesic-information, ..."
    add("--learn", metavar="BUILDER", help=learn)
    kinds = ("unbiased", "self-touch", "multi-touch", "biased")
    babble = "distribution of the random touches to learn from (default unbiased)"
    add("--babble", default="unbiased", choices=kinds, help=babble)
    add("--touches", type=_integer, default=3000, metavar="N", help="number of random touches (default 3000)")


def _comparison_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the comparison with another map."""
    add = parser.add_argument_group("comparison").add_argument
    add("--compare", metavar="FILE", help="also measure this map (.npz), layout (.ini) or table with u, v")
    fix = "correct modules of a compared layout that seem rotated or mirrored"
    add("--fix-modules", action="store_true", help=fix)
    exact = "measure stress by exact geodesics from N taxels (default: by the heat method from 250, within 2 %%)"
    add("--exact-distances", type=_count, metavar="N", help=exact)


def _add_inspect(command: _Add) -> None:
    inspect = command("inspect", help="content of a robot, skin, map, taxel file, scene or recording")
    add = inspect.add_argument
    add("input", nargs="?", metavar="FILE|NAME")
    add("--costs", action="store_true", help="measure the cost of each effect of a scene on this computer")
    add(
        "--mapping", action="store_true", help="print a template that names the fields of a JSON, YAML or CSV of taxels"
    )
    _report(inspect)
    add("--plugins", action="store_true", help="list the installed plug-ins instead")
    _robot_options(inspect)
    _json(inspect)


def _add_weigh(command: _Add) -> None:
    weigh = command("weigh", help="known-load check: put a mass on the skin and compare the reading with its weight")
    add = weigh.add_argument
    add("input", nargs="?", default="arm", metavar="SCENE|ROBOT", help="robot whose skin is checked (default arm)")
    _robot_options(weigh)
    add("--mass", type=_positive, default=0.1, metavar="KG", help="mass of the weight (default 0.1)")
    add("--model", metavar="NAME", help="contact model (default: the scene's)")
    _report(weigh)
    _json(weigh)


def _add_calibrate(command: _Add) -> None:
    calibrate = command("calibrate", help="force calibration: fit the curve of each taxel to a log of known loads")
    add = calibrate.add_argument
    log = "rows of force, mass_g or pressure_kPa, and reading with taxel, id or x, y, z, or a column for each taxel"
    add("input", metavar="LOG.csv", help=log)
    _scene_options(calibrate)
    _output(calibrate, metavar="FILE.csv", help="write the calibration, for listen --calibration and File > Connect")
    add("--changes", action="store_true", help="readings are changes from the untouched skin: no row at load 0 needed")
    add("--folds", type=_folds, default=5, metavar="N", help="parts of the cross-validation, 2 to 20 (default 5)")
    add("--seed", type=_seed, default=0)
    _report(calibrate)
    _json(calibrate)


def _add_place(command: _Add) -> None:
    place = command("place", help="spatial calibration: place taxels on the mesh of their link, or by known touches")
    add = place.add_argument
    add("input", metavar="TAXELS", help="taxel file: positions (.txt), .csv, .npz, .json, .yaml or URDF")
    add("--robot", metavar="NAME|FILE", help="robot that carries the taxels (default: icub for .txt)")
    add("--link", metavar="LINK", help="link that carries them, if the file does not state it")
    _robot_options(place)
    add("--by", choices=("patch", "module"), default="patch", help="rigid groups (default patch: all taxels of a link)")
    touches = (
        "place by touches instead: rows of x, y, z and a column for each taxel; with --robot, of another link of it: "
        "touching_link, x, y, z in its frame, and joint:NAME"
    )
    add("--touches", metavar="FILE.csv", help=touches)
    readings = "with --touches: file of readings; the touches are then a trajectory with time, x, y, z"
    add("--readings", metavar="FILE", help=readings)
    changes = "with --touches: readings are changes from the untouched skin: no row without a place needed"
    add("--changes", action="store_true", help=changes)
    add("--seed", type=_seed, default=0)
    _output(place, metavar="FILE", help="write the taxels at their new places: .csv, .txt, .npz, .json")
    _report(place)
    _json(place)


def _add_budget(command: _Add) -> None:
    budget = command("budget", help="best settings of all stages of a scene within a limit of time or error")
    add = budget.add_argument
    add("scene_file", nargs="?", metavar="SCENE", help="name or file of a scene")
    _scene_options(budget)
    add("--milliseconds", type=_positive, metavar="MS", help="maximum time of a tick")
    add("--millimetres", type=_positive, metavar="MM", help="maximum error of the place of a contact")
    add("--newtons", type=_positive, metavar="N", help="maximum error of the force of a contact")
    _json(budget)


def _add_replay(command: _Add) -> None:
    replay = _recording_command(command, "replay", "step through a recording")
    replay.add_argument("--verify", action="store_true", help="simulate the recorded inputs again and compare")
    _output(replay, "--stimuli", metavar="FILE.toml", help="save the pokes of the recording as a stimulus script")
    _overwrite(replay)
    _json(replay)


def _add_recover(command: _Add) -> None:
    recover = _recording_command(command, "recover", "recover the intact part of a truncated recording")
    _output(recover, required=True, metavar="FIXED.mcap")
    _overwrite(recover)
    _json(recover)


def _add_trim(command: _Add) -> None:
    trim = _recording_command(command, "trim", "copy a part, or each labelled episode, of a recording to new files")
    add = trim.add_argument
    target = {"metavar": "PART.mcap|DIR", "help": "a folder with --episodes"}
    _output(trim, folder="episodes", required=True, **target)
    add("--from", dest="start", type=_not_negative, default=0.0, metavar="SECONDS", help="default: begin")
    add("--to", dest="end", type=_not_negative, metavar="SECONDS", help="default: end")
    add("--episodes", action="store_true", help="write a file for each labelled episode")
    _overwrite(trim, "replace existing files")
    _json(trim)


def _add_export(command: _Add) -> None:
    export = _recording_command(command, "export", "recording for other programs: CSV, Parquet, HDF5, LeRobot, a film")
    add = export.add_argument
    add("--to", required=True, metavar="FORMAT", help=f"{', '.join(EXPORT_FORMATS)}, or that of a plug-in")
    _output(export, required=True, metavar="FILE|DIR", help="target; a folder must not exist")
    add("--from", dest="start", type=_not_negative, default=0.0, metavar="SECONDS", help="default: begin")
    add("--until", dest="end", type=_not_negative, metavar="SECONDS", help="default: end")
    _overwrite(export)
    width = "width of tactile images; 0 for none (default 64)"
    add("--image-width", type=_integer, default=64, metavar="PIXELS", help=width)
    rate = "pictures per second in films and logs (default 25)"
    add("--rate", type=_positive, default=25.0, metavar="HZ", help=rate)
    fps = "rows per second of a LeRobot data set, with a window of the readings since the previous row (default: all)"
    add("--fps", type=_count, metavar="N", help=fps)
    _json(export)


def _add_compare(command: _Add) -> None:
    compare = command("compare", help="run several controllers on the same stimulus and compare them")
    add = compare.add_argument
    add("input", metavar="SCENE|FILE.mcap", help="a scene (its stimulus script) or a recording (its inputs)")
    _robot_options(compare)
    add("--controllers", required=True, metavar="NAME,NAME", help="impedance, hold_force, hybrid, qp, ...")
    add("--task", metavar="NAME", help="task, instead of that of the scene or recording: follow_path, ...")
    add("--for", dest="seconds", type=_positive, metavar="SECONDS", help="simulated seconds")
    folder = "write every tick of every controller there as CSV, and a page"
    _output(compare, folder="output", metavar="DIR", help=folder)
    _overwrite(compare, "replace existing files")
    _json(compare)


def _add_study(command: _Add) -> None:
    text = "measure accuracy against computing time; writes CSV, JSON, an HTML report and, with pyarrow, Parquet"
    study = command("study", help=text)
    add = study.add_argument
    add("name", metavar="NAME", help=" or ".join(STUDY_NAMES))
    folder = "write CSV, JSON and HTML there (default studies)"
    _output(study, folder="output", default="studies", metavar="DIR", help=folder)
    _workers(study, "number of parallel cases, 0 for one per core; parallel runs distort the measured times")
    _resume_options(
        study, "continue the run in DIR: measure unfinished cases", "replace the run in DIR, finished or interrupted"
    )
    budget = "stop after 90s, 30min or 2h with the best possible table: complete seeds first, none for settled cases"
    add("--budget", type=_duration, metavar="TIME", help=budget)
    add("--quick", action="store_true", help="run a few small cases only")
    add("--seed", type=_seed, default=0)
    _json(study)


def _add_guide(command: _Add) -> None:
    guide = command("guide", help="show the guide in a window; without a display, print the place of its pages")
    guide.add_argument("page", nargs="?", default="index", metavar="PAGE", help="maps, touch, control, ...")
    _json(guide)


def _add_desktop(command: _Add) -> None:
    desktop = command("desktop", help="add the window to the menu of a Linux desktop, for this user")
    desktop.add_argument("--remove", action="store_true", help="remove it from the menu")
    _json(desktop)


def _add_cache(command: _Add) -> None:
    cache = command("cache", help="prepared robots, skins and maps that are stored on disk")
    cache.add_argument("--clear", action="store_true", help="remove them")
    _json(cache)


_COMMANDS = (
    _add_gui,
    _add_run,
    _add_listen,
    _add_check,
    _add_screenshot,
    _add_film,
    _add_map,
    _add_inspect,
    _add_weigh,
    _add_calibrate,
    _add_place,
    _add_budget,
    _add_replay,
    _add_recover,
    _add_trim,
    _add_export,
    _add_compare,
    _add_study,
    _add_guide,
    _add_desktop,
    _add_cache,
)


def _recording_command(command: _Add, name: str, text: str) -> _Parser:
    parser = command(name, help=text)
    parser.add_argument("input", metavar=_RECORDING)
    return parser


def _output(parser: argparse.ArgumentParser, *names: str, folder: str = "", **options: Any) -> None:
    """Add an option that names a file to write; ``tactile_maps.cli.shared.outputs`` checks it first.

    Args:
        parser: Parser of the command.
        names: Names of the option; ``-o`` and ``--output`` by default.
        folder: Name of the option with which it is a folder; its own name if it always is.
        options: Other arguments of ``add_argument``; the file has the extension in ``metavar``.
    """
    found = re.search(r"\.\w+", options.get("metavar", ""))
    suffix = "" if found is None else found.group()
    action = parser.add_argument(*(names or ("-o", "--output")), type=_file_name, **options)
    parser.set_defaults(outputs=(*(parser.get_default("outputs") or ()), (action.dest, folder, suffix)))


def _report(parser: argparse.ArgumentParser) -> None:
    text = "also write the result as a page to read, print or send"
    _output(parser, "--report", metavar="FILE.html", help=text)
    _overwrite(parser)


def _overwrite(parser: argparse.ArgumentParser, text: str = "replace an existing file") -> None:
    parser.add_argument("--overwrite", action="store_true", help=text)


def _resume_options(parser: argparse.ArgumentParser, resume: str, overwrite: str) -> None:
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--resume", action="store_true", help=resume)
    group.add_argument("--overwrite", action="store_true", help=overwrite)


def _workers(parser: argparse.ArgumentParser, jobs: str) -> None:
    """Add the options of the workers, which ``tactile_maps.cli.shared.workers`` reads."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--jobs", type=_integer, default=1, metavar="N", help=jobs)
    cluster = "use the workers of this Dask scheduler instead, for example tcp://host:8786"
    group.add_argument("--cluster", metavar="ADDRESS", help=cluster)


def _source_options(parser: argparse.ArgumentParser, token: str, remote: str) -> None:
    """Add the options of a source of readings, which ``tactile_maps.cli.shared.source_options`` reads."""
    add = parser.add_argument
    add("--speed", type=_positive, metavar="X", help="play a file X times as fast (default: as fast as possible)")
    add("--ids", metavar="FILE.csv", help="taxel of each id in the packets, if different from the skin")
    add("--mapping", metavar="FILE.toml", help="topics and fields of ROS 2 messages")
    add("--token", help=token)
    add("--token-file", metavar="FILE", help="file with the token; unlike a command line, a file can be private")
    add("--remote", action="store_true", help=remote)


def _scene_options(parser: argparse.ArgumentParser) -> None:
    add = partial(parser.add_argument, default=argparse.SUPPRESS)
    add("--scene", metavar="NAME|FILE", help="name or file of a scene")
    add("--robot", metavar="NAME|FILE", help="name or file of a robot; 'none' for a skin alone")
    skin = "taxels on the robot (.txt .csv .json .yaml .npz, URDF sensors), or a folder of .txt; may be repeated"
    add("--skin", action="append", metavar="FILE", help=skin)
    add("--link", metavar="LINK", help="link that carries them, if FILE does not state it")
    _robot_options(parser)


def _robot_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of every command that loads a robot."""
    add = partial(parser.add_argument, default=argparse.SUPPRESS)
    home = "home posture: joint positions [rad, m]; other joints as the scene or robot states them"
    add("--home", type=_home, metavar="JOINT=VALUE,...", help=home)
    roots = "folder with ROS packages or meshes that a robot file names; may be repeated"
    add("--package-root", action="append", type=_folder, metavar="DIR", help=roots)


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="the last line of output is one JSON object")


def _folder(text: str) -> str:
    if not os.path.isdir(text):
        raise argparse.ArgumentTypeError(f"the folder does not exist: {text}")
    return text


def _file_name(text: str) -> str:
    if not text.strip():
        raise argparse.ArgumentTypeError("the name of the file is empty: give a name, or leave the option out")
    return text


def _parsed(kind: str, parse: Callable[[str], Value], accepts: Callable[[Value], bool]) -> Callable[[str], Value]:
    """Return the type of an option whose text must be of a kind.

    Args:
        kind: Description that follows "must be".
        parse: Converts the text; raises ValueError.
        accepts: Whether a value is valid.
    """

    def convert(text: str) -> Value:
        try:
            value = parse(text)
        except ValueError:
            pass
        else:
            if accepts(value):
                return value
        raise argparse.ArgumentTypeError(f"must be {kind}: {text if len(text) <= 40 else f'{text[:40]}…'}")

    return convert


def _whole(text: str) -> int:
    """Return a whole number; long texts are rejected before they are converted."""
    if not re.fullmatch("[+-]?[0-9]{1,19}", text):
        raise ValueError
    return int(text)


def _values(separator: str, count: int, parse: Callable[[str], Value]) -> Callable[[str], tuple[Value, ...]]:
    """Return a function that parses so many values with a separator."""

    def convert(text: str) -> tuple[Value, ...]:
        parts = text.lower().split(separator)
        if len(parts) != count:
            raise ValueError
        return tuple(parse(part) for part in parts)

    return convert


def _joint_positions(text: str) -> dict[str, float]:
    pairs = [part.rpartition("=") for part in text.split(",")]
    return {name.strip(): float(value) for name, _, value in pairs}


def _time(text: str) -> float:
    """Return the seconds of ``90s``, ``30min`` or ``2h``."""
    unit = text.lstrip("0123456789.")
    if unit not in _UNITS:
        raise ValueError
    return float(text.removesuffix(unit)) * _UNITS[unit]


def _between(low: int, high: int) -> Callable[[int], bool]:
    return lambda value: low <= value < high


_integer = _parsed("a whole number below 2^63", _whole, _between(-(2**63), 2**63))
_seed = _parsed("a whole number from 0 up, below 2^63", _whole, _between(0, 2**63))
_count = _parsed("a whole number above 0, below 2^63", _whole, _between(1, 2**63))
_folds = _parsed("2 to 20", _whole, _between(2, 21))
_port = _parsed("0 to 65535", _whole, _between(0, 65536))
_positive = _parsed("above 0 and below a million", float, lambda value: 0 < value < 1e6)
_not_negative = _parsed("0 or more and below a million", float, lambda value: 0 <= value < 1e6)
_threshold = _parsed("0.001 to 100,000,000 counts or kPa", float, lambda value: 1e-3 <= value <= 1e8)
_duration = _parsed("a time such as 90s, 30min or 2h", _time, lambda value: 0 < value < 3600e6)
_size = _parsed(
    "like 1400x900, each side 400 to 8000", _values("x", 2, _whole), lambda sides: all(400 <= n <= 8000 for n in sides)
)
_grid = _parsed("like 8x12", _values("x", 2, _whole), lambda counts: min(counts) > 0)
_millimetres = _parsed("like 170x85", _values("x", 2, float), lambda _: True)
_corner = _parsed("three numbers like 10,0,-25.5", _values(",", 3, lambda part: 1e-3 * float(part)), lambda _: True)
_home = _parsed(
    "like elbow=1.2,wrist=-0.3",
    _joint_positions,
    lambda found: all(name and math.isfinite(value) for name, value in found.items()),
)

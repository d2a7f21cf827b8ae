"""Everything the command line understands."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable, Mapping
from functools import partial
from importlib.metadata import version
from typing import Any

from tactile_maps.cli.shared.output import write_error, write_output
from tactile_maps.studies.catalogue import STUDY_NAMES

EXPORT_FORMATS = ("csv", "parquet", "npz", "hdf5", "lerobot", "rosbag2", "mp4", "rerun")
"""Those of ``tactile_maps.export.export``, which is not imported to parse a line."""
EPILOG = """exit codes: 0 done, 1 the work failed and says why, 2 bad usage,
            130 Ctrl-C, 143 SIGTERM, 129 SIGHUP or a closed terminal, 131 SIGQUIT
robots: arm, two_arms (ours); ur5e, icub, icub_whole (pip install 'tactile-maps[robots]'); a file;
        a model in MENAGERIE_ROOT or known to mujoco-menagerie"""

_UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}


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

    def _print_message(self, message: str, file: object = None) -> None:
        if file is sys.stdout:
            write_output(message)
        else:
            write_error(message)


def build_parser() -> argparse.ArgumentParser:
    """The parser; ``command`` is empty for the window."""
    parser = _Parser(
        prog="tactile-maps",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Tactile maps of robot skin: simulate, control contact, record and measure.",
    )
    parser.add_argument("--version", action="version", version=f"tactile-maps {version('tactile-maps')}")
    _scene_options(parser)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    _add_window_commands(commands)
    _add_file_commands(commands)
    _add_compare(commands)
    _add_study(commands)
    _add_guide(commands)
    _add_desktop(commands)
    _add_cache(commands)
    return parser


def _add_window_commands(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    gui = commands.add_parser("gui", help="open the window (the default)")
    gui.add_argument("file", nargs="?", metavar="FILE", help="scene, robot, mesh, skin, recording or map to open")
    _scene_options(gui)
    gui.add_argument("--json", action="store_true", help="report a failure as one JSON object")
    run = commands.add_parser("run", help="simulate, and record, without a window")
    run.add_argument("scene_file", nargs="?", metavar="SCENE", help="a scene's name or file")
    _scene_options(run)
    run.add_argument(
        "--for", dest="seconds", type=_positive, metavar="SECONDS", help="simulated seconds (default 5, or the sweep's)"
    )
    run.add_argument("--stimuli", metavar="FILE.toml", help="stimulus script to play instead of the scene's")
    _output(
        run,
        "-o",
        "--output",
        folder="sweep",
        metavar="FILE.mcap|DIR",
        help="record to this file; a folder with --sweep",
    )
    run.add_argument("--sweep", metavar="FILE.toml", help="record many variations of the scene, with an index of them")
    again = run.add_mutually_exclusive_group()
    again.add_argument("--overwrite", action="store_true", help="replace an existing file; with --sweep, begin anew")
    again.add_argument("--resume", action="store_true", help="with --sweep: record what is not in DIR yet")
    _workers(run, "with --sweep: recordings made in parallel, 0 for one per core")
    run.add_argument(
        "--no-viewers",
        dest="viewers",
        action="store_false",
        help="leave out the messages for Foxglove, Lichtblick and Rerun: a third of the size; replays are the same",
    )
    run.add_argument(
        "--serve", action="store_true", help="live for Foxglove and Lichtblick, in real time, on this computer alone"
    )
    run.add_argument(
        "--rerun",
        nargs="?",
        const="rerun+http://127.0.0.1:9876/proxy",
        metavar="ADDRESS",
        help="live to a Rerun viewer that is open, in real time (default: on this computer)",
    )
    run.add_argument("--port", type=_port, default=8765, help="of --serve (default 8765; 0 for any that is free)")
    run.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS", help="of --serve; 0.0.0.0 lets the network watch"
    )
    _json(run)
    _add_listen(commands)
    shot = commands.add_parser("screenshot", help="a picture of the whole window, without a display")
    _scene_options(shot)
    shot.add_argument("--at", type=_not_negative, default=2.0, metavar="SECONDS", help="simulated seconds (default 2)")
    shot.add_argument("--theme", choices=("dark", "light"), default="dark")
    shot.add_argument("--size", type=_size, default=(1400, 900), metavar="WxH", help="in pixels (default 1400x900)")
    _output(shot, "-o", "--output", required=True, metavar="FILE", help=".png; of a figure .svg or .pdf too")
    _overwrite(shot)
    shot.add_argument(
        "--figure", choices=("views", "robot", "map"), help="of robot, map or both for a paper, instead of the window"
    )
    shot.add_argument(
        "--mm", type=_millimetres, default=(170.0, 85.0), metavar="WxH", help="of a figure (default 170x85)"
    )
    shot.add_argument("--dpi", type=_integer, default=300, help="of a figure's pixels (default 300)")
    shot.add_argument(
        "--colours", choices=("paper", "light", "dark"), default="paper", help="of a figure (default paper)"
    )
    _json(shot)
    film = commands.add_parser("film", help="body and map of a recording as a film, without a display")
    film.add_argument("input", metavar="FILE.mcap")
    _output(film, "-o", "--output", required=True, metavar="FILE.mp4")
    _overwrite(film)
    film.add_argument("--size", type=_size, default=(1280, 640), metavar="WxH", help="in pixels (default 1280x640)")
    film.add_argument("--rate", type=_positive, default=25.0, metavar="HZ", help="pictures a second (default 25)")
    film.add_argument("--from", dest="first", type=_not_negative, metavar="SECONDS", help="begin there (default 0)")
    film.add_argument("--to", dest="last", type=_positive, metavar="SECONDS", help="end there (default: the end)")
    film.add_argument("--theme", choices=("dark", "light"), default="dark")
    _json(film)


def _add_listen(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    listen = commands.add_parser("listen", help="readings of a real skin: show statistics and contacts, and record")
    add = listen.add_argument
    add("source", metavar="SOURCE", help="udp:, zmq:, serial:, yarp: or ros2: address, or a file")
    _scene_options(listen)
    _output(listen, "-o", "--output", metavar="FILE.mcap", help="record to this file")
    _overwrite(listen, "replace existing files")
    add("--for", dest="seconds", type=_positive, metavar="SECONDS", help="stop after so long (default: at Ctrl-C)")
    add("--speed", type=_positive, metavar="X", help="play a file X times as fast (default: as fast as possible)")
    add("--ids", metavar="FILE.csv", help="taxel of each id that is sent, if not as in the skin")
    add("--calibration", metavar="FILE", help="gain and offset of each taxel (.csv, .toml)")
    add("--mode", choices=("raw", "baseline", "kPa"), help="what contacts are read from (default: as known)")
    add(
        "--tare",
        type=_integer,
        metavar="N",
        help="take the first N readings as those of the untouched skin (50 recommended)",
    )
    level = "a taxel is in contact from this value on, in the unit shown: counts or kPa (default: from the tare)"
    add("--threshold", type=_threshold, metavar="VALUE", help=level)
    add("--weight", type=_positive, metavar="KG", help="calibrate by this mass, which lies on the skin at the end")
    seconds = "mean of so long at the end (default 0.5); refused while the sum still changes by 5 %%"
    add("--weight-seconds", type=_positive, metavar="SECONDS", help=seconds)
    _output(listen, "--save-calibration", metavar="FILE.csv", help="write the calibration found with --weight")
    add("--controller", metavar="NAME", help="show the motion that this controller requests of the robot")
    send = "send the motion of --controller to udp://HOST:PORT or zmq://HOST:PORT: the robot may move"
    stop = "a safety stop ends sending, not listening, and the exit code is 0 all the same"
    add("--send", metavar="ADDRESS", help=f"{send}; {stop}")
    speed = "with --send: limit of every joint (default 0.2); those of the robot's model apply as well"
    add("--max-speed", type=float, metavar="RAD/S", help=speed)
    add("--max-force", type=float, metavar="N", help="with --send: a stronger contact ends sending (default 15)")
    add("--mapping", metavar="FILE.toml", help="topics and fields of ROS 2 messages")
    add("--token", help="token required in every packet; udp: and zmq: need one with --send or --remote")
    add("--token-file", metavar="FILE", help="with the token; other users may read a command line, but not the file")
    add("--remote", action="store_true", help="listen to other machines too, which needs a token, and send to them")
    _json(listen)


def _add_guide(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    guide = commands.add_parser("guide", help="the guide, in a window; without a display, where its pages are")
    guide.add_argument("page", nargs="?", default="index", metavar="PAGE", help="maps, touch, control, ...")
    _json(guide)


def _add_desktop(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    desktop = commands.add_parser("desktop", help="put the window into the menu of a Linux desktop, for this user")
    desktop.add_argument("--remove", action="store_true", help="take it out again")
    _json(desktop)


def _add_cache(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    cache = commands.add_parser("cache", help="prepared robots, skins and maps that are kept on disk")
    cache.add_argument("--clear", action="store_true", help="remove them")
    _json(cache)


def _add_file_commands(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    _add_map(commands)
    inspect = commands.add_parser("inspect", help="what a robot, skin, map, taxel file, scene or recording holds")
    inspect.add_argument("input", nargs="?", metavar="FILE|NAME")
    inspect.add_argument("--costs", action="store_true", help="measure what each effect of a scene costs here")
    _output(inspect, "--report", metavar="FILE.html", help="write it as a page too, to be read, printed or sent")
    _overwrite(inspect)
    inspect.add_argument("--plugins", action="store_true", help="list the plug-ins that are installed instead")
    _robot_options(inspect)
    _json(inspect)
    weigh = commands.add_parser(
        "weigh", help="known-load check: lay a mass on the skin and compare the measured force with its weight"
    )
    weigh.add_argument(
        "input", nargs="?", default="arm", metavar="SCENE|ROBOT", help="robot whose skin is checked (default arm)"
    )
    _robot_options(weigh)
    weigh.add_argument("--mass", type=_positive, default=0.1, metavar="KG", help="mass of the weight (default 0.1)")
    weigh.add_argument("--model", metavar="NAME", help="contact model (default: the scene's)")
    _output(weigh, "--report", metavar="FILE.html", help="write it as a page too, to be read, printed or sent")
    _overwrite(weigh)
    _json(weigh)
    budget = commands.add_parser(
        "budget", help="the best settings of every stage for a scene within a limit of time or of error"
    )
    budget.add_argument("scene_file", nargs="?", metavar="SCENE", help="a scene's name or file")
    _scene_options(budget)
    budget.add_argument("--milliseconds", type=_positive, metavar="MS", help="a tick may take at most")
    budget.add_argument("--millimetres", type=_positive, metavar="MM", help="a contact's place may be off by at most")
    budget.add_argument("--newtons", type=_positive, metavar="N", help="a contact's force may be off by at most")
    _json(budget)
    replay = commands.add_parser("replay", help="step through a recording")
    replay.add_argument("input", metavar="FILE.mcap")
    replay.add_argument("--verify", action="store_true", help="simulate the recorded inputs again and compare")
    _output(replay, "--stimuli", metavar="FILE.toml", help="save the pokes of the recording as a stimulus script")
    _overwrite(replay)
    _json(replay)
    recover = commands.add_parser("recover", help="recover the intact part of a truncated recording")
    recover.add_argument("input", metavar="FILE.mcap")
    _output(recover, "-o", "--output", required=True, metavar="FIXED.mcap")
    _overwrite(recover)
    _json(recover)
    trim = commands.add_parser("trim", help="cut a part, or each labelled episode, out of a recording into new files")
    trim.add_argument("input", metavar="FILE.mcap")
    _output(
        trim,
        "-o",
        "--output",
        folder="episodes",
        required=True,
        metavar="PART.mcap|DIR",
        help="a folder with --episodes",
    )
    trim.add_argument("--from", dest="start", type=_not_negative, default=0.0, metavar="SECONDS", help="default: begin")
    trim.add_argument("--to", dest="end", type=_not_negative, metavar="SECONDS", help="default: end")
    trim.add_argument("--episodes", action="store_true", help="a file for each episode that was labelled")
    _overwrite(trim, "replace existing files")
    _json(trim)
    export = commands.add_parser("export", help="a recording for other programs: CSV, Parquet, HDF5, LeRobot, a film")
    export.add_argument("input", metavar="FILE.mcap")
    formats = f"{', '.join(EXPORT_FORMATS)}, or a plug-in's"
    export.add_argument("--to", required=True, metavar="FORMAT", help=formats)
    _output(export, "-o", "--output", required=True, metavar="FILE|DIR", help="write there; a folder must not exist")
    _overwrite(export)
    export.add_argument(
        "--image-width", type=_integer, default=64, metavar="PIXELS", help="of tactile images; 0 for none (default 64)"
    )
    export.add_argument(
        "--rate", type=_positive, default=25.0, metavar="HZ", help="pictures a second in films and logs (default 25)"
    )
    _json(export)


def _add_compare(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    compare = commands.add_parser("compare", help="run several controllers on the same stimulus and compare them")
    compare.add_argument(
        "input", metavar="SCENE|FILE.mcap", help="a scene (its stimulus script) or a recording (its inputs)"
    )
    _robot_options(compare)
    compare.add_argument(
        "--controllers", required=True, metavar="NAME,NAME", help="impedance, hold_force, hybrid, qp, ..."
    )
    compare.add_argument(
        "--task", metavar="NAME", help="task, instead of that of the scene or recording: follow_path, ..."
    )
    compare.add_argument("--for", dest="seconds", type=_positive, metavar="SECONDS", help="simulated seconds")
    _output(
        compare,
        "-o",
        "--output",
        folder="output",
        metavar="DIR",
        help="write every tick of every controller there as CSV, and a page",
    )
    _overwrite(compare, "replace existing files")
    _json(compare)


def _add_study(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    study = commands.add_parser(
        "study",
        help="measure accuracy against computing time; writes CSV, JSON, an HTML report and, with pyarrow, Parquet",
    )
    study.add_argument("name", metavar="NAME", help=" or ".join(STUDY_NAMES))
    _output(
        study,
        "-o",
        "--output",
        folder="output",
        default="studies",
        metavar="DIR",
        help="write CSV, JSON and HTML there (default studies)",
    )
    _workers(study, "cases run in parallel, 0 for one per core; parallel runs distort the measured times")
    again = study.add_mutually_exclusive_group()
    again.add_argument("--resume", action="store_true", help="go on with the run in DIR: measure what is not done")
    again.add_argument("--overwrite", action="store_true", help="replace the run in DIR, finished or interrupted")
    study.add_argument(
        "--budget",
        type=_duration,
        metavar="TIME",
        help="stop after 90s, 30min or 2h with the best table there is: whole seeds first, no more where settled",
    )
    study.add_argument("--quick", action="store_true", help="run a few small cases only")
    study.add_argument("--seed", type=_seed, default=0)
    _json(study)


def _output(parser: argparse.ArgumentParser, *names: str, folder: str = "", **options: Any) -> None:
    """Add an option that names a file to write; ``tactile_maps.cli.shared.outputs`` checks it first.

    Args:
        parser: The command's parser.
        names: The option's names.
        folder: The name of the option with which it is a folder; its own name for one that always is.
        options: Other arguments of ``add_argument``.
    """
    options.setdefault("type", _file_name)
    action = parser.add_argument(*names, **options)
    parser.set_defaults(outputs=(*(parser.get_default("outputs") or ()), (action.dest, folder)))


def _overwrite(parser: argparse.ArgumentParser, text: str = "replace an existing file") -> None:
    parser.add_argument("--overwrite", action="store_true", help=text)


def _workers(parser: argparse.ArgumentParser, jobs: str) -> None:
    """Who does what is to be done many times: ``tactile_maps.cli.shared.workers`` reads it."""
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--jobs", type=_integer, default=1, metavar="N", help=jobs)
    who.add_argument(
        "--cluster", metavar="ADDRESS", help="on the workers of this Dask scheduler instead, as tcp://host:8786"
    )


def _add_map(commands: argparse._SubParsersAction) -> None:  # type: ignore[type-arg]
    make = commands.add_parser("map", help="robot, mesh, taxel or skin file -> tactile map and its quality")
    make.add_argument(
        "input",
        metavar="INPUT",
        help="robot, mesh, taxel file (.txt .csv .json .npz, URDF sensors), skin, map, recording",
    )
    _output(
        make,
        "-o",
        "--output",
        metavar="FILE",
        help=".npz (everything), .obj (with UV), .svg, .png, .json (Genoa), .csv, .xml (MuJoCo)",
    )
    _overwrite(make)
    make.add_argument("--seed", type=_seed, default=0)
    _json(make)
    _skin_options(make)
    _flattening_options(make)
    _learning_options(make)
    _comparison_options(make)


def _skin_options(parser: argparse.ArgumentParser) -> None:
    """What of a robot or mesh is covered, and where its taxels lie."""
    add = parser.add_argument_group("skin").add_argument
    add("--links", nargs="+", default=[], metavar="LINK", help="links to cover, or the link that carries the taxels")
    add(
        "--robot",
        metavar="NAME",
        help="robot that the taxels of a file are on (default: icub for .txt); 'none' without",
    )
    add(
        "--surface",
        default="outer",
        choices=("outer", "all", "cover"),
        help="part of a mesh to cover (default outer)",
    )
    add("--taxels", type=_integer, default=1000, help="number of taxels to place (default 1000)")
    add("--pitch", type=float, metavar="MM", help="distance between taxels, instead of their number")
    add(
        "--pattern",
        default="even",
        choices=("even", "hexagonal", "modules"),
        help="of the taxels (default even)",
    )
    add("--grid", type=_grid, metavar="ROWSxCOLUMNS", help="a grid of taxels instead, on the link named by --links")
    add("--from", dest="first", type=_corner, metavar="X,Y,Z", help="the grid's first corner, link frame [mm]")
    add("--to", dest="last", type=_corner, metavar="X,Y,Z", help="its last corner [mm]")
    add(
        "--mirrored",
        action=argparse.BooleanOptionalAction,
        help="of the two grids with these corners the second, or the first (default: the flat one)",
    )
    add("--density", choices=("curvature",), help="more taxels where curvature is high")
    add("--keep-border", type=float, metavar="MM", help="no taxels within this distance of a border")
    _robot_options(parser)


def _flattening_options(parser: argparse.ArgumentParser) -> None:
    """How its patches are flattened, or which map is taken instead."""
    add = parser.add_argument_group("flattening").add_argument
    add("--method", default="symmetric-dirichlet", help="symmetric-dirichlet (default), tutte, harmonic, lscm, ...")
    add("--lengths", type=float, default=1.0, metavar="0-1", help="preserve lengths (1, default) or angles (0)")
    add(
        "--cut",
        "--seams",
        dest="seams",
        type=_integer,
        metavar="N",
        help="extra seams per patch (default: automatic)",
    )
    add("--uv", metavar="FILE.obj", help="take the map from this unwrapped OBJ instead of flattening")


def _learning_options(parser: argparse.ArgumentParser) -> None:
    """From which touches a map is learned instead."""
    add = parser.add_argument_group("learning from touch").add_argument
    add(
        "--learn",
        metavar="BUILDER",
        help="learn the map from tactile readings: information-distance, geodesic-information, ...",
    )
    add(
        "--babble",
        default="unbiased",
        choices=("unbiased", "self-touch", "multi-touch", "biased"),
        help="distribution of the random touches to learn from (default unbiased)",
    )
    add("--touches", type=_integer, default=3000, metavar="N", help="number of random touches (default 3000)")


def _comparison_options(parser: argparse.ArgumentParser) -> None:
    """With which other map it is compared."""
    add = parser.add_argument_group("comparison").add_argument
    add("--compare", metavar="FILE", help="measure this map (.npz), layout (.ini) or table with u, v as well")
    add(
        "--fix-modules",
        action="store_true",
        help="correct modules of a compared layout that seem rotated or mirrored",
    )
    add(
        "--exact-distances",
        type=_count,
        metavar="N",
        help="measure stress by exact geodesics from N taxels (default: by the heat method from 250, within 2 %%)",
    )


def _scene_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", metavar="NAME|FILE", default=argparse.SUPPRESS, help="a scene's name or file")
    parser.add_argument(
        "--robot",
        metavar="NAME|FILE",
        default=argparse.SUPPRESS,
        help="a robot's name or file; 'none' for a skin alone",
    )
    parser.add_argument(
        "--skin",
        metavar="FILE",
        default=argparse.SUPPRESS,
        help="taxels that the robot wears (.txt .csv .json .npz, URDF sensors), or a folder of .txt",
    )
    parser.add_argument(
        "--link", metavar="LINK", default=argparse.SUPPRESS, help="link that carries them, where FILE does not say"
    )
    _robot_options(parser)


def _robot_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of every command that loads a robot."""
    parser.add_argument(
        "--home",
        type=_home,
        default=argparse.SUPPRESS,
        metavar="JOINT=VALUE,...",
        help="home posture: joint positions [rad, m]; other joints as the scene or robot states them",
    )
    parser.add_argument(
        "--package-root",
        action="append",
        type=_folder,
        default=argparse.SUPPRESS,
        metavar="DIR",
        help="folder with ROS packages or meshes that a robot file names; may be repeated",
    )


def _folder(text: str) -> str:
    if not os.path.isdir(text):
        raise argparse.ArgumentTypeError(f"there is no such folder: {text}")
    return text


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="the last line of output is one JSON object")


def _file_name(text: str) -> str:
    if not text.strip():
        raise argparse.ArgumentTypeError("the name of the file is empty: give a name, or leave the option out")
    return text


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"must be above 0 and below a million: {text}")
    return value


def _threshold(text: str) -> float:
    low = 0.001
    high = 1e8
    value = float(text)
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"must be {low:g} to {high:,.0f} counts or kPa: {text}")
    return value


def _duration(text: str) -> float:
    """Seconds of ``90s``, ``30min`` or ``2h``."""
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    unit = text.lstrip("0123456789.")
    if unit not in _UNITS:
        raise argparse.ArgumentTypeError(f"{text!r} is no time: write 90s, 30min or 2h")
    return _positive(number) * _UNITS[unit]


def _integer(text: str, least: int = -(2**63), kind: str = "a whole number") -> int:
    """Return a whole number of at most 64 bits; its user checks its range."""
    if not re.fullmatch("[+-]?[0-9]{1,19}", text) or not least <= int(text) < 2**63:
        shown = text if len(text) <= 40 else f"{text[:40]}…"
        raise argparse.ArgumentTypeError(f"must be {kind} below 2^63: {shown}")
    return int(text)


def _seed(text: str) -> int:
    return _integer(text, 0, "a whole number from 0 up,")


def _count(text: str) -> int:
    return _integer(text, 1, "a whole number above 0,")


def _port(text: str) -> int:
    if not _is_short_number(text) or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"must be 0 to 65535: {text[:40]}")
    return int(text)


def _is_short_number(text: str) -> bool:
    return text.isdecimal() and len(text) <= 18


def _not_negative(text: str) -> float:
    value = float(text)
    if not 0 <= value < 1e6:
        raise argparse.ArgumentTypeError(f"must be 0 or more and below a million: {text}")
    return value


def _size(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(_is_short_number(part) and 400 <= int(part) <= 8000 for part in parts):
        raise argparse.ArgumentTypeError(f"must be like 1400x900, each side 400 to 8000: {text[:40]}")
    return int(parts[0]), int(parts[1])


def _millimetres(text: str) -> tuple[float, float]:
    try:
        width, height = (float(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"must be like 170x85: {text}") from error
    return width, height


def _home(text: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (word.strip() for word in part.rpartition("="))
        try:
            found[name] = float(value)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"must be like elbow=1.2,wrist=-0.3: {text}") from error
        if not (name and equals and math.isfinite(found[name])):
            raise argparse.ArgumentTypeError(f"must be like elbow=1.2,wrist=-0.3: {text}")
    return found


def _grid(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(_is_short_number(part) and int(part) for part in parts):
        raise argparse.ArgumentTypeError(f"must be like 8x12: {text[:40]}")
    return int(parts[0]), int(parts[1])


def _corner(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (1e-3 * float(part) for part in text.split(","))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"must be three numbers like 10,0,-25.5: {text}") from error
    return x, y, z

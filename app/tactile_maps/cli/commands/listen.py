"""``listen``: receive readings of a real skin without a window, and report arrival, contacts and a recording."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from typing import Any

from tactile_maps.cli.shared.output import print_result, print_warning, progress_line, write_error
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.cli.shared.source_options import (
    OTHER_SKIN,
    blaming,
    connection_of,
    refuse_silence,
    token_of,
    until_interrupted,
)
from tactile_maps.control.controller_registry import check_settings, settings_from
from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import LiveError, UsageError, counted, names_text
from tactile_maps.live.calibration.calibration import ValueMode, check_mass, load_calibration, save_calibration
from tactile_maps.live.channels.matching import load_matching
from tactile_maps.live.channels.tare import check_tare
from tactile_maps.live.frame_recording import FrameRecording
from tactile_maps.live.motion.command_latency import LatencyFigures, latency_text
from tactile_maps.live.motion.command_loop import CommandLoop
from tactile_maps.live.motion.driver_channel import (
    check_not_source,
    check_readings,
    check_sending,
    driver_channel,
    needs_token,
)
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import DEADLINE, MotionLimits, SendingState, StopReason
from tactile_maps.live.prepare import prepare_measured
from tactile_maps.live.session.connection import Connection, ConnectionState, ConnectionStatus, refused_text
from tactile_maps.live.session.facts import MeasuredFacts, few_heard, silent_text, swapped_texts
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.sources.open import is_live
from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.scene import Scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

CLOCK: Callable[[], float] = time.monotonic
"""Clock of the ages of readings and commands [s]. Tests replace it to be independent of the machine."""
_REPORT_PERIOD = 1.0
"""Period of the statistics on a terminal [s]."""
_LATENCY = ("median", "p95", "p99", "largest")
_FINISH_SECONDS = 1.0
"""Maximum time to process waiting readings after a live source ends [s]."""
_PAUSE = 0.01
"""Period of checks while listening [s]."""
_WEIGHT_SECONDS = 0.5
"""Default averaging time of ``--weight`` [s]."""


def execute(arguments: argparse.Namespace) -> int:
    """Receive readings until the source ends, the time is over, or Ctrl-C."""
    if arguments.weight is not None:
        with blaming("--weight"):
            check_mass(arguments.weight)
    arguments.token = token_of(arguments)
    limits = _limits(arguments)
    scene = _with_reading(scene_from_arguments(arguments), arguments)
    settings = _settings(arguments, scene)
    if arguments.send:
        check_sending(arguments.send, remote=arguments.remote)
        check_not_source(arguments.send, arguments.source)
        _refuse_no_motion(arguments, settings.controller)
        check_readings(arguments.source, arguments.token)
    connection = connection_of(arguments, clock=CLOCK)
    prepared = prepare_measured(scene, progress=progress_line())
    session = _session(arguments, connection, prepared)
    motion = None
    if arguments.controller or arguments.send:
        motion = MotionOutput(session, settings, connection.ages, clock=CLOCK)
    stated = connection.source.address
    connection.open()
    with ExitStack() as outer:
        outer.callback(connection.close)
        if connection.source.address != stated:  # port 0: the sender needs the port that was chosen
            write_error(f"tactile-maps: listening at {connection.source.address}\n")
        recording = None
        with ExitStack() as stack:
            if arguments.output:
                address = connection.source.address
                recorder = Recorder(prepared, arguments.output, overwrite=arguments.overwrite, measured=address)
                recording = FrameRecording(outer.enter_context(recorder), lossless=connection.source.finite)
                stack.callback(recording.close)
            if motion is not None and arguments.send:
                put = stack.enter_context(driver_channel(arguments.send))
                accepted = None if arguments.send_anyway else ""
                motion.start_sending(put, limits, token=arguments.token, accepted=accepted)
                stack.callback(motion.halt)
            result = _listen(connection, session, recording, motion, arguments.seconds)
        if arguments.weight is not None:
            calibration = session.weights.weigh(arguments.weight)
            if arguments.save_calibration:
                save_calibration(calibration, arguments.save_calibration)
    result["file"] = arguments.output
    result["left_out"] = 0 if recording is None else recording.left_out
    _report(result, connection, session, motion, as_json=arguments.json)
    return 0


def _report(
    result: dict[str, Any],
    connection: Connection,
    session: MeasuredSession,
    motion: MotionOutput | None,
    *,
    as_json: bool,
) -> None:
    """Print what was received, and warnings.

    Raises:
        LiveError: No reading arrived.
    """
    status = connection.status
    facts = session.facts
    result |= _figures(status, facts, session) | {"source": status.address}
    if motion is not None:
        result["motion"] = _motion_figures(motion, session)
    for warning in _warnings(session, facts, status):
        print_warning(warning)
    if result["left_out"]:
        print_warning(f"{counted(result['left_out'], 'frame')} not recorded: the disk is too slow")
    refuse_silence(connection, facts)
    latency = None if motion is None else motion.latency.figures
    print_result(result, _rows(result, status, latency), as_json=as_json)


def _with_reading(scene: Scene, arguments: argparse.Namespace) -> Scene:
    """Return the scene with the given contact settings; the threshold is in the unit shown, where 1 count is 1 kPa."""
    reading = dict(scene.reading)
    if arguments.threshold is not None:
        reading["threshold"] = 1e3 * arguments.threshold
    if arguments.close_contacts is not None:
        reading["close_contacts"] = arguments.close_contacts
    return replace(scene, reading=reading)


def _session(arguments: argparse.Namespace, connection: Connection, prepared: PreparedScene) -> MeasuredSession:
    table = load_matching(arguments.ids, prepared.skin) if arguments.ids else None
    calibration = load_calibration(arguments.calibration, prepared.skin) if arguments.calibration else None
    finite = connection.source.finite
    if arguments.inverted and calibration is not None:
        remedy = "Negate the gains in the file instead"
        raise UsageError("a calibration states the sign of its gains", value="--inverted", remedy=remedy)
    inverted = arguments.inverted
    session = MeasuredSession(
        prepared, connection.take, table=table, calibration=calibration, finite=finite, inverted=inverted
    )
    if arguments.mode:
        session.readings.request_mode(ValueMode(arguments.mode))
    if arguments.tare is not None:
        with blaming("--tare"):
            check_tare(arguments.tare)
            session.tare(arguments.tare)
    if arguments.weight is not None:
        with blaming("--weight-seconds"):
            session.weights.remember(_WEIGHT_SECONDS if arguments.weight_seconds is None else arguments.weight_seconds)
    return session


def _limits(arguments: argparse.Namespace) -> MotionLimits:
    """Return the limits of motion; raises UsageError."""
    limits = MotionLimits()
    if arguments.max_speed is not None:
        with blaming("--max-speed"):
            limits = replace(limits, speed=arguments.max_speed)
    if arguments.max_force is not None:
        with blaming("--max-force"):
            limits = replace(limits, force=arguments.max_force)
    return limits


def _settings(arguments: argparse.Namespace, scene: Scene) -> ControlSettings:
    """Return the settings of the controller; raises UsageError for an unknown one."""
    settings = settings_from(dict(scene.control))
    if arguments.controller:
        with blaming("--controller", problem="unknown controller"):
            settings = check_settings(replace(settings, controller=arguments.controller))
    return settings


def _refuse_no_motion(arguments: argparse.Namespace, controller: str) -> None:
    """Refuse to send if no motion can result.

    Raises:
        UsageError: The controller outputs torques, or the readings are not shown as pressures.
    """
    mode = arguments.mode
    if controller == "impedance":
        remedy = "Add --controller hold_force, hybrid or another that outputs velocities"
        if needs_token(arguments.source) and arguments.token is None:
            remedy += ", and --token, which the sender must include in every packet"
        raise UsageError("this controller outputs no motion to send", place="--send", value=controller, remedy=remedy)
    if mode in (ValueMode.RAW, ValueMode.BASELINE):
        remedy = "Leave out --mode, and add --calibration FILE if the sender does not send pressures"
        raise UsageError(
            "motion requires forces: calibrated readings", place="--send", value=f"--mode {mode}", remedy=remedy
        )


class ContactSummary:
    """Contacts so far. Mutable."""

    def __init__(self) -> None:
        self.contacts: set[int] = set()
        self.strongest = 0.0
        self._counts: Counter[int] = Counter()

    def add(self, frame: Frame) -> None:
        """Add the contacts of a frame."""
        self.contacts.update(region.id for region in frame.regions)
        self._counts[len(frame.regions)] += 1
        self.strongest = max(self.strongest, frame.strongest_force)

    @property
    def at_once(self) -> int:
        """Most frequent number of contacts at once while the skin is touched; the larger one of equals."""
        return max((number for number in self._counts if number), key=lambda one: (self._counts[one], one), default=0)


def _listen(
    connection: Connection,
    session: MeasuredSession,
    recording: FrameRecording | None,
    motion: MotionOutput | None,
    seconds: float | None,
) -> dict[str, Any]:
    """Listen until the end, and return figures of the contacts."""
    summary = ContactSummary()
    start = time.monotonic()
    reported = start
    message = ("", -_REPORT_PERIOD)

    def each(frame: Frame) -> None:
        summary.add(frame)
        if recording is not None:
            recording.put(frame, session.inputs)

    commands = CommandLoop(connection, session, motion, each)
    with until_interrupted(live=is_live(connection.source.address)), closing(commands):
        connection.start()
        commands.start()
        while not commands.finished.wait(_PAUSE) and (seconds is None or time.monotonic() - start < seconds):
            commands.raise_error()
            if recording is not None and recording.error is not None:
                if motion is not None:
                    motion.halt(StopReason.RECORDING, str(recording.error))
                raise recording.error
            _refuse_doubtful_tare(motion)
            message = _report_sending(message, motion, time.monotonic())
            if time.monotonic() - reported > _REPORT_PERIOD:
                reported = time.monotonic()
                _report_status(connection.status, len(session.frame.regions))
    listened = time.monotonic() - start
    connection.close()
    commands.finish(_FINISH_SECONDS)
    _refuse_doubtful_tare(motion)
    force = None if session.readings.units.force is None else summary.strongest
    return {
        "listened_s": listened,
        "readings": commands.taken,
        "contacts": len(summary.contacts),
        "contacts_at_once": summary.at_once,
        "max_force_N": force,
    }


def _refuse_doubtful_tare(motion: MotionOutput | None) -> None:
    """Raise LiveError if nothing was sent because the tare is doubtful; a later doubt stops the motion only."""
    if motion is None or motion.sending.stopped is not StopReason.DOUBTFUL_TARE or motion.sending.sent:
        return
    remedy = "Leave the skin untouched and start again; --send-anyway sends nevertheless"
    raise LiveError(
        "no motion is sent: the tare is doubtful", place="--send", value=motion.sending.detail, remedy=remedy
    )


def _report_sending(last: tuple[str, float], motion: MotionOutput | None, now: float) -> tuple[str, float]:
    """Print changes of the state of sending, reasons to wait at most once a second; return the last text and time."""
    if motion is None:
        return last
    sending = motion.sending
    text = _sending_text(sending, motion.speed_limits)
    if text == last[0] or (sending.waiting is not None and now - last[1] < _REPORT_PERIOD):
        return last
    write_error(f"tactile-maps: {text}\n")
    return text, now


def _sending_text(sending: SendingState, speed_limits: str) -> str:
    """Text that a user must see at once; empty if there is none."""
    if sending.waiting is not None:
        return f"motion is not sent yet: waiting for {sending.waiting}"
    if sending.stopped is not None:
        detail = f" ({sending.detail})" if sending.detail else ""
        return f"sending stopped: {sending.stopped}{detail}"
    return f"motion is sent, {speed_limits}" if sending.sending else ""


def _report_status(status: ConnectionStatus, touched: int) -> None:
    if sys.stderr.isatty():
        problem = f", {status.problem}" if status.problem else ""
        write_error(
            f"\r\x1b[K{status.state}: {status.rate:.0f} Hz, {counted(touched, 'contact')}, {_counts(status)}{problem}"
        )


def _counts(status: ConnectionStatus) -> str:
    counts = vars(status.counts)
    shown = [f"{number} {name}" for name, number in counts.items() if number or name in ("received", "lost")]
    return ", ".join(shown)


def _figures(status: ConnectionStatus, facts: MeasuredFacts, session: MeasuredSession) -> dict[str, Any]:
    delay = status.delay
    return {
        **vars(status.counts),
        "loss": status.counts.loss,
        "reconnects": status.reconnects,
        "refused_senders": dict(status.refused),
        "delay_ms": None if delay is None else {name: 1e3 * value for name, value in vars(delay).items()},
        "mean_rate_hz": session.mean_rate,
        "shown": facts.readings,
        "refused": facts.refused,
        "mistimed": facts.mistimed,
        "unit": facts.unit,
        "mode": facts.mode,
        "calibrated": facts.calibrated,
        "tared": facts.tared,
        "inverted": facts.inverted,
        "falling": facts.falling,
        "falling_taxels": list(facts.falling_taxels),
        "touched_in_tare": list(facts.touched_in_tare),
        "held_in_tare": list(facts.held_in_tare),
        "taxels": len(session.prepared.skin),
        "unheard": facts.unheard,
        "unknown": list(facts.unknown),
        "unknown_values": facts.unknown_values,
        "ambiguous": list(facts.ambiguous),
        "ambiguous_values": facts.ambiguous_values,
        "wrong_channels": list(facts.wrong_channels),
        "wrong_channel_values": facts.wrong_channel_values,
        "unknown_joints": list(facts.unknown_joints),
        "silent": [vars(one) for one in facts.silent],
        "swapped": [vars(one) for one in facts.swapped],
    }


def _motion_figures(motion: MotionOutput, session: MeasuredSession) -> dict[str, Any]:
    target = motion.requested
    sending = motion.sending
    late = motion.latency.figures
    names = session.prepared.robot.joint_names
    return {
        "controller": motion.settings.controller,
        "velocities": None if target is None else dict(zip(names, target.velocity.tolist(), strict=True)),
        "limits": [] if target is None else [limit_text(limit) for limit in target.limits],
        "problem": motion.problem,
        "sent": sending.sent,
        "slowed": sending.slowed,
        "stopped": sending.stopped,
        "detail": sending.detail,
        "latency_ms": None if late is None else {name: 1e3 * getattr(late, name) for name in _LATENCY},
        "deadline_ms": 1e3 * DEADLINE,
        "deadline_misses": 0 if late is None else late.misses,
    }


def _motion_text(motion: dict[str, Any]) -> str:
    """Text of the last requested motion and of what was sent."""
    parts = [motion["controller"]]
    if motion["problem"]:
        parts.append(f"no motion: {motion['problem']}")
    elif motion["velocities"]:
        name, speed = max(motion["velocities"].items(), key=lambda item: abs(item[1]))
        parts.append(f"at the end {name} at {speed:+.3f} rad/s")
    if motion["stopped"]:
        detail = f" ({motion['detail']})" if motion["detail"] else ""
        parts.append(f"{motion['sent']} sent, {motion['slowed']} of them slowed, until {motion['stopped']}{detail}")
    return "; ".join([*parts, *motion["limits"]])


def _rows(result: dict[str, Any], status: ConnectionStatus, latency: LatencyFigures | None) -> dict[str, object]:
    delay = status.delay
    strongest = result["max_force_N"]
    force = "forces unknown: not calibrated" if strongest is None else f"up to {strongest:.2f} N"
    return {
        "Source": status.address,
        "Readings": f"{result['shown']} in {result['listened_s']:.2f} s, {result['mean_rate_hz']:.1f} per second",
        "Arrival": f"{_counts(status)} ({100 * status.counts.loss:.2g} % lost or late)",
        "Delay": "unknown"
        if delay is None
        else f"median {1e3 * delay.median:.1f} ms, 95 % within {1e3 * delay.p95:.1f} ms, relative to the fastest",
        "Taxels": f"{result['taxels'] - result['unheard']} of {result['taxels']} received",
        "Values": f"{result['unit']}, shown as {result['mode']}{', tared' if result['tared'] else ''}",
        "Contacts": f"{result['contacts']}, most of the time {result['contacts_at_once']} at once, {force}",
        "Motion": _motion_text(result["motion"]) if "motion" in result else None,
        "Commands": None if latency is None else latency_text(latency),
        "Recorded to": result["file"] or "nothing",
    }


def _warnings(session: MeasuredSession, facts: MeasuredFacts, status: ConnectionStatus) -> Iterator[str]:
    """Warnings for the user although readings arrived."""
    if status.counts.malformed:
        yield f"{counted(status.counts.malformed, 'packet')} not decoded; the last: {status.malformed}"
    if status.refused:
        yield f"after motion was sent, packets of a second sender were rejected: {refused_text(status.refused)}"
    if status.counts.overflowed:
        yield f"{counted(status.counts.overflowed, 'reading')} dropped, because they arrived too fast to be processed"
    if facts.refused:
        yield f"{counted(facts.refused, 'reading')} rejected; the last: {facts.problem}"
    if facts.mistimed:
        yield f"{counted(facts.mistimed, 'reading')} with inconsistent times; times of arrival were used"
    if facts.unknown:
        values = counted(facts.unknown_values, "value")
        yield f"{values} of taxels that the skin does not have: {names_text(facts.unknown)}"
    if few := few_heard(facts, len(session.prepared.skin)):
        yield f"{few}; {OTHER_SKIN}"
    if facts.ambiguous:
        which = f"{names_text(facts.ambiguous)}; name them link:id, or use --ids"
        yield f"{counted(facts.ambiguous_values, 'value')} of ids that several taxels have: {which}"
    if facts.wrong_channels:
        wrong = names_text(facts.wrong_channels)
        yield f"{counted(facts.wrong_channel_values, 'value')} with a wrong number of channels: {wrong}"
    if facts.unknown_joints:
        yield f"joints that the robot does not have: {names_text(facts.unknown_joints)}"
    if facts.silent:
        names = [silent_text(session.prepared.skin, one) for one in facts.silent]
        yield f"{counted(len(names), 'channel')} without a change while the neighbours change: {names_text(names)}"
    if facts.swapped:
        words = names_text(swapped_texts(session.prepared.skin, facts.swapped))
        yield f"{counted(len(facts.swapped), 'probable swap')} of channels: {words}"
    if facts.falling:
        change = "leave out --inverted" if facts.inverted else "add --inverted"
        yield (
            f"neighbouring taxels fall below their baseline together ({names_text(facts.falling_taxels)}). If the "
            f"values fall under pressure, {change}; if the skin was touched during the tare, repeat the tare"
        )
    if facts.touched_in_tare:
        named = names_text(facts.touched_in_tare)
        yield f"the skin was touched during the tare; the readings meanwhile were left out for {named}"
    if facts.held_in_tare:
        named = names_text(facts.held_in_tare)
        yield (
            f"neighbouring taxels read far more than the others during the tare ({named}). If something touched them, "
            "contacts there are hidden: tare the skin untouched"
        )
    if status.state is ConnectionState.FAILED:
        yield f"the source failed: {status.problem}"
    if facts.taring:
        yield "the readings ended before the skin was tared"

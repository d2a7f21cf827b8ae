"""Background jobs: progress, results, failure, cancellation and crashes, in a process and inline."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
import time

import numpy as np
import pytest

from tactile_maps.core.errors import UsageError
from tactile_widgets.jobs.executor import InlineExecutor, Job, Kept, ProcessExecutor, _work

LONG = 30_000
DIED = "It ended. Try again."


def square(number, report):
    report("squaring", 0.5)
    report.part(number)
    return number * number


def zeros(count, _report):
    return np.zeros(count)


def reject(number, _report):
    raise UsageError("too large", value=number)


def read_truncated_file(_report):
    raise EOFError("cap.tmap")


def return_function(_report):
    return lambda: None


def crash(_report):
    os.kill(os.getpid(), signal.SIGKILL)


def crash_with(_total, report):
    crash(report)


def report_and_crash(report):
    report("almost there", 0.9)
    os._exit(1)


def sleep(report):
    report("sleeping", 0.0)
    time.sleep(60)


def nap(report):
    time.sleep(0.3)
    report("awake", 1.0)


def add(total, number, _report):
    total.value.append(number)
    return sum(total.value)


def reject_all():
    raise UsageError("cannot be made")


def is_warm(_report):
    return os.getpid()


class JobLog(list):
    """Everything that was reported, as (kind, value) in order."""

    def start(self, executor, function, *arguments, **options):
        """Start a job that reports here."""

        def note(kind):
            return lambda value: self.append((kind, value))

        return executor.start(
            Job(function, *arguments, died=DIED, **options),
            note("finished"),
            note("failed"),
            progressed=lambda text, share: self.append(("progressed", (text, share))),
            received=note("received"),
        )


@pytest.fixture
def log():
    return JobLog()


@pytest.fixture(scope="module")
def shared_process(qapp):
    """A process for all tests that leave it running: starting one takes longer than most of them."""
    made = ProcessExecutor("test")
    yield made
    made.close()
    made.deleteLater()
    assert not mp.active_children(), "a process outlived its executor"


@pytest.fixture
def process(shared_process):
    yield shared_process
    shared_process.close()
    assert not mp.active_children()


@pytest.fixture(params=["process", "inline"])
def executor(request, shared_process):
    return shared_process if request.param == "process" else InlineExecutor("test")


@pytest.fixture
def wait(qtbot):
    """Wait until an executor has run all of its jobs."""
    return lambda executor: qtbot.waitUntil(lambda: not executor.busy, timeout=LONG)


def test_jobs_run_in_order_and_report_progress_parts_and_results(executor, log, wait):
    jobs = [log.start(executor, square, number) for number in (2, 3)]
    wait(executor)
    assert log == [
        entry
        for number in (2, 3)
        for entry in (("progressed", ("squaring", 0.5)), ("received", number), ("finished", number**2))
    ]
    assert all(job.begun and job.done for job in jobs)


@pytest.mark.parametrize("count", [10, 10**7], ids=["small", "larger than a pipe"])
def test_result_arrives_whole_and_read_only_from_a_process(shared_process, log, wait, count):
    log.start(shared_process, zeros, count)
    wait(shared_process)
    ((kind, array),) = log
    assert (kind, array.shape) == ("finished", (count,))
    assert not array.flags.writeable


def test_error_of_a_function_fails_only_its_job(executor, log, wait):
    log.start(executor, reject, 7)
    log.start(executor, square, 1)
    wait(executor)
    assert log[0] == ("failed", "too large (found: 7).")
    assert log[-1] == ("finished", 1)


@pytest.mark.parametrize(
    ("function", "words"),
    [(read_truncated_file, "An unexpected problem: EOFError: cap.tmap."), (return_function, "An unexpected problem: ")],
    ids=["unforeseen error", "result that cannot be pickled"],
)
def test_unforeseen_error_in_a_process_fails_the_job_and_the_process_continues(
    shared_process, log, wait, function, words
):
    log.start(shared_process, function)
    log.start(shared_process, is_warm)
    wait(shared_process)
    assert log[0][0] == "failed"
    assert log[0][1].startswith(words)
    assert log[1] == ("finished", shared_process.pid)


def test_value_kept_for_several_jobs_is_made_once(executor, log, wait):
    total = Kept(list)
    for number in (1, 2, 3):
        log.start(executor, add, total, number)
    log.start(executor, square, 5)
    log.start(executor, add, total, 4)
    log.start(executor, add, Kept(list), 4)
    wait(executor)
    assert [value for kind, value in log if kind == "finished"] == [1, 3, 6, 25, 10, 4]


def test_value_that_cannot_be_made_fails_each_job_that_needs_it(executor, log, wait):
    broken = Kept(reject_all)
    for _ in range(2):
        log.start(executor, add, broken, 1)
    wait(executor)
    assert log == [("failed", "cannot be made.")] * 2


@pytest.mark.long
def test_arguments_wait_in_the_window_until_the_process_reads_them(process, log, wait):
    """A pipe holds 64 kB: writing a larger argument before the process reads would block the window."""
    process.close()
    jobs = [log.start(process, square, np.ones(10**5)) for _ in range(2)]
    assert not any(job.begun for job in jobs)
    wait(process)
    assert process.ready
    assert not process._timer.isActive(), "nothing is expected"


@pytest.mark.long
def test_warm_process_imports_before_the_first_job(process, log, wait, qtbot):
    process.warm(is_warm)
    qtbot.waitUntil(lambda: process.ready, timeout=LONG)
    pid = process.pid
    log.start(process, is_warm)
    wait(process)
    assert log == [("finished", pid)]


@pytest.mark.long
def test_cancelled_job_reports_nothing_and_the_next_one_runs(process, log, qtbot, wait):
    long = log.start(process, sleep)
    waiting = log.start(process, square, 2)
    log.start(process, square, 3)
    qtbot.waitUntil(lambda: bool(log), timeout=LONG)
    pid = process.pid
    waiting.cancel()
    assert process.pid == pid, "a job that waits is removed; the process continues"
    begun = time.monotonic()
    long.cancel()
    long.cancel()
    assert time.monotonic() - begun < 1
    wait(process)
    assert log == [
        ("progressed", ("sleeping", 0.0)),
        ("progressed", ("squaring", 0.5)),
        ("received", 3),
        ("finished", 9),
    ]


@pytest.mark.long
def test_ignored_job_reports_nothing_and_its_process_continues(process, log, qtbot, wait):
    ignored = log.start(process, nap)
    qtbot.waitUntil(lambda: ignored.begun, timeout=LONG)
    pid = process.pid
    ignored.ignore()
    log.start(process, is_warm)
    log.start(process, square, 3).ignore()
    wait(process)
    assert log == [("finished", pid)]


@pytest.mark.long
def test_close_ends_process_and_jobs_and_may_be_repeated(process, log, qtbot):
    log.start(process, sleep)
    log.start(process, square, 2)
    qtbot.waitUntil(lambda: bool(log), timeout=LONG)
    process.close()
    process.close()
    assert process.pid is None
    assert not process.busy
    qtbot.wait(50)
    assert log == [("progressed", ("sleeping", 0.0))]


def test_crash_fails_the_running_job_and_the_next_job_starts_another_process(process, log, wait):
    log.start(process, crash)
    log.start(process, square, 2)
    wait(process)
    assert log[0] == ("failed", DIED)
    assert log[-1] == ("finished", 4)


def test_reports_sent_before_a_crash_arrive_before_the_failure(process, log, qtbot):
    process.warm()
    qtbot.waitUntil(lambda: process.ready, timeout=LONG)
    log.start(process, report_and_crash)
    process._timer.stop()
    process._process.join(10)  # so that report and end are read together
    process._on_timer()
    assert log == [("progressed", ("almost there", 0.9)), ("failed", DIED)]


def test_crash_fails_a_job_if_the_next_one_starts_before_the_crash_was_noticed(process, log, wait, qtbot):
    total = Kept(list)
    process.warm()
    qtbot.waitUntil(lambda: process.ready, timeout=LONG)
    log.start(process, crash_with, total)
    process._process.join(10)
    log.start(process, square, 2)
    log.start(process, add, total, 1)
    wait(process)
    assert log == [
        ("failed", DIED),
        ("failed", DIED),
        ("progressed", ("squaring", 0.5)),
        ("received", 2),
        ("finished", 4),
    ]


@pytest.mark.long
def test_process_that_died_idle_is_replaced(process, log, wait):
    for _ in range(2):
        log.start(process, square, 2)
        wait(process)
        kill(process)
    assert [entry for entry in log if entry[0] in ("finished", "failed")] == [("finished", 4)] * 2


@pytest.mark.long
def test_job_whose_kept_value_was_lost_fails(process, log, wait):
    total = Kept(list)
    log.start(process, add, total, 1)
    wait(process)
    kill(process)
    for _ in range(2):
        log.start(process, add, total, 5)
        wait(process)
    assert log == [("finished", 1), ("failed", DIED), ("finished", 5)]


def kill(process):
    """Kill an idle process, and wait until it has ended."""
    os.kill(process.pid, signal.SIGKILL)
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)


def test_event_loop_runs_between_reading_a_result_and_delivering_it(process, log, qtbot):
    process.warm()
    qtbot.waitUntil(lambda: process.ready, timeout=LONG)
    log.start(process, square, 2)
    process._timer.stop()
    qtbot.waitUntil(lambda: process._on_timer() or bool(process._read), timeout=LONG)
    assert not log
    process._on_timer()
    assert log


@pytest.mark.parametrize("jobs", [(), ((square, (2,)),)], ids=["before it is ready", "while it works"])
def test_process_ends_without_output_after_the_window_has_closed(jobs):
    ours, theirs = mp.Pipe()
    for job in jobs:
        ours.send(job)
    ours.close()
    on_interrupt = signal.getsignal(signal.SIGINT)
    try:
        _work(theirs, ())
    finally:
        signal.signal(signal.SIGINT, on_interrupt)
        theirs.close()


def wait_forever_in_a_process(connection):
    """Start an executor's process in a process that is killed."""
    from PySide6.QtCore import QCoreApplication

    _app = QCoreApplication([])
    executor = ProcessExecutor("orphan")
    executor.warm()
    connection.send(executor.pid)
    time.sleep(60)


@pytest.mark.long
def test_process_ends_when_the_program_is_killed(qtbot):
    ours, theirs = mp.Pipe()
    program = mp.get_context("spawn").Process(target=wait_forever_in_a_process, args=(theirs,))
    program.start()
    worker = ours.recv()
    program.kill()
    program.join()
    qtbot.waitUntil(lambda: not alive(worker), timeout=LONG)


def alive(pid):
    """Whether a process runs."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_inline_executor_defers_deferrable_jobs_until_requested(log):
    executor = InlineExecutor("test")
    log.start(executor, square, 2, deferrable=True)
    log.start(executor, square, 3)
    assert log[-1] == ("finished", 9)
    assert executor.busy
    log.clear()
    executor.run_waiting()
    assert log[-1] == ("finished", 4)
    assert not executor.busy


def test_holding_inline_executor_runs_nothing_before_requested(log):
    executor = InlineExecutor("test", hold=True)
    log.start(executor, square, 2)
    log.start(executor, square, 3).cancel()
    log.start(executor, square, 4).ignore()
    assert not log
    executor.run_waiting()
    assert log[-1] == ("finished", 4)

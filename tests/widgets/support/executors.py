"""Executors for tests: processes for some names only, and jobs of scenes that wait until they are released."""

from __future__ import annotations

from tactile_widgets.jobs.executor import InlineExecutor, ProcessExecutor
from tactile_widgets.jobs.scene_jobs import SceneJobs


def in_process(*names):
    """Make executors: processes for these names, inline ones for others."""

    def make(name, parent):
        return (ProcessExecutor if name in names else InlineExecutor)(name, parent)

    return make


class InlineSceneJobs(SceneJobs):
    """Jobs that run while the caller waits."""

    def __init__(self):
        super().__init__(InlineExecutor("prepare"))


class HeldJobs(SceneJobs):
    """Jobs that run when they are released."""

    def __init__(self):
        super().__init__(InlineExecutor("prepare", hold=True))

    @property
    def held(self):
        """Requests that wait."""
        return [running.job.arguments[0] for running in self.executor._waiting]

    def release(self):
        self.executor.run_waiting()

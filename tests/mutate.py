"""Apply listed mutations to the code, one at a time, and check that the default tests fail.

    .venv/bin/python -m tests.mutate                 # every mutation of tests/mutations.toml
    .venv/bin/python -m tests.mutate tank runner     # mutations whose description or file contains one of these words
    .venv/bin/python -m tests.mutate --tenth 7       # the random tenth with this seed
    .venv/bin/python -m tests.mutate --check         # only check that each mutation applies to the present code

Each mutation is made in a copy of the tree, where the tests named with it run as in the default run. Prints the
survivors and exits with 1 if there are any. Cost: about 10 s for each mutation and core.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).resolve().parents[1]
LIST = Path(__file__).with_name("mutations.toml")
COPIED = ("app", "widgets", "tests", "pyproject.toml")
"""Paths that are copied; the rest of the tree is linked."""
SECONDS = 600.0
"""Time limit of the tests [s]; a mutation that exceeds it counts as killed."""


@dataclass(frozen=True)
class Mutation:
    """Change of the code that tests must detect.

    Attributes:
        what: Description of the resulting fault.
        file: Path relative to the root.
        old: Text to be replaced, which occurs exactly once.
        new: Replacement.
        tests: Test files of which the default cases must fail.
    """

    what: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def problem(self, root: Path = ROOT) -> str:
        """Return why the mutation cannot be applied; empty if it can."""
        if not (root / self.file).is_file():
            return f"{self.file} does not exist"
        text = (root / self.file).read_text(encoding="utf8")
        if text.count(self.old) != 1:
            return f"{self.file} has {self.old!r} {text.count(self.old)} times"
        try:
            compile(text.replace(self.old, self.new), self.file, "exec", dont_inherit=True)
        except SyntaxError as error:  # any test would detect it
            return f"{self.file} cannot be compiled: {error.msg}"
        missing = [test for test in self.tests if not (root / test).exists()]
        return f"there is no {', '.join(missing)}" if missing else ""


def mutations() -> tuple[Mutation, ...]:
    """Read the list."""
    rows = tomllib.loads(LIST.read_text(encoding="utf8"))["mutation"]
    return tuple(Mutation(**{**row, "tests": tuple(row["tests"])}) for row in rows)


def random_tenth(seed: int) -> tuple[Mutation, ...]:
    """Draw a tenth of the list."""
    listed = mutations()
    return tuple(random.Random(seed).sample(listed, -(-len(listed) // 10)))


def copy_tree(folder: Path) -> Path:
    """Copy the tree to ``folder``."""
    for entry in ROOT.iterdir():
        target = folder / entry.name
        if entry.name not in COPIED:
            target.symlink_to(entry)
        elif entry.is_dir():
            shutil.copytree(entry, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(entry, target)
    return folder


def outcome(mutation: Mutation, tree: Path) -> str:
    """Return ``killed``, ``SURVIVED``, or why the outcome is unknown."""
    if problem := mutation.problem(tree):
        return f"CANNOT BE MADE: {problem}"
    path = tree / mutation.file
    text = path.read_text(encoding="utf8")
    path.write_text(text.replace(mutation.old, mutation.new), encoding="utf8")
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *mutation.tests]
    # -B, because tests/conftest.py overrides the environment variable.
    env = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    try:
        done = subprocess.run(command, cwd=tree, env=env, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return "killed: it never ended"
    finally:
        path.write_text(text, encoding="utf8")
    if done.returncode == 1:
        lines = (line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR")))
        return f"killed by {next(lines, 'FAILED a test').split()[1]}"
    return "SURVIVED" if done.returncode == 0 else f"CANNOT BE RUN: {done.stdout[-2000:]}"


def run(chosen: Sequence[Mutation], jobs: int) -> int:
    """Run the mutations, print their outcomes, and return the number that were not killed."""
    alive = 0
    with tempfile.TemporaryDirectory(prefix="mutate") as folder, ThreadPoolExecutor(jobs) as pool:
        trees: SimpleQueue[Path] = SimpleQueue()
        for number in range(jobs):
            (Path(folder) / str(number)).mkdir()
            trees.put(copy_tree(Path(folder) / str(number)))

        def one(mutation: Mutation) -> str:
            tree = trees.get()
            try:
                return outcome(mutation, tree)
            finally:
                trees.put(tree)

        for mutation, found in zip(chosen, pool.map(one, chosen), strict=True):
            alive += not found.startswith("killed")
            sys.stdout.write(f"{mutation.what}\n    {mutation.file}: {found}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(chosen)} mutations, {alive} not killed\n")
    return alive


def main(words: Sequence[str] | None = None) -> int:
    """Run the program."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="only mutations with one of these in description or file")
    parser.add_argument("--tenth", type=int, metavar="SEED", help="only a random tenth of the list")
    parser.add_argument("--check", action="store_true", help="only whether each can be made")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(words)
    every = mutations() if options.tenth is None else random_tenth(options.tenth)
    chosen = [m for m in every if not options.words or any(word in m.what + m.file for word in options.words)]
    if options.check:
        problems = [f"{m.what}: {problem}" for m in chosen if (problem := m.problem())]
        sys.stdout.write("\n".join([*problems, f"{len(chosen)} mutations, {len(problems)} cannot be made\n"]))
        return bool(problems)
    return bool(run(chosen, options.jobs))


if __name__ == "__main__":
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    sys.exit(main())

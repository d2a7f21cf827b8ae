#!/bin/sh
# Complete check without a display: installs what it needs, then runs lint, types, import rules, spelling and tests.
#
#     sh tests/run.sh                about ten minutes on two cores from an installed environment
#     sh tests/run.sh --all          every test and case
#     sh tests/run.sh --tests-only   only the tests
#
# On Windows it runs in Git Bash. Other arguments are passed to pytest; tests/conftest.py states what the default omits.
set -eu
cd "$(dirname "$0")/.."
sh assets/install/install.sh --tests
tools=.venv/bin
[ -x "$tools/python" ] || tools=.venv/Scripts
export QT_QPA_PLATFORM=offscreen
unset DISPLAY WAYLAND_DISPLAY || true

if [ "${1:-}" = "--tests-only" ]; then
    shift
else
    # mypy takes as long as all other checks of the text together.
    "$tools/mypy" &
    types=$!
    "$tools/ruff" check .
    "$tools/ruff" format --check --quiet .
    "$tools/typos"
    "$tools/lint-imports"
    wait "$types"
fi

"$tools/python" -m pytest --numprocesses logical --dist worksteal "$@"

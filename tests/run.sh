#!/bin/sh
# The whole check, from nothing: installs what it needs, then lint, types, import rules and tests, without a display.
#
#     sh tests/run.sh          at most eight minutes on two cores from an installed environment
#     sh tests/run.sh --all    every test and case
#
# Anything more is handed to pytest; `tests/conftest.py` says what the default leaves out.
set -eu
cd "$(dirname "$0")/.."
sh assets/install/install.sh --tests
export QT_QPA_PLATFORM=offscreen
unset DISPLAY WAYLAND_DISPLAY || true

# Types take as long as all other checks of the text together.
.venv/bin/mypy &
types=$!
.venv/bin/ruff check .
.venv/bin/ruff format --check --quiet .
.venv/bin/typos
.venv/bin/lint-imports
wait "$types"

.venv/bin/python -m pytest --numprocesses logical --dist worksteal "$@"

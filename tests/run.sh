#!/bin/sh
# The whole check, from nothing: installs what it needs, then lint, types, import rules and every test, without a display.
set -eu
cd "$(dirname "$0")/.."
sh assets/install/install.sh --tests
export QT_QPA_PLATFORM=offscreen
unset DISPLAY WAYLAND_DISPLAY || true
.venv/bin/ruff check .
.venv/bin/ruff format --check --quiet .
.venv/bin/mypy
.venv/bin/lint-imports
.venv/bin/typos
.venv/bin/python -m pytest "$@"

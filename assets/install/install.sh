#!/bin/sh
# Installs Tactile Maps into .venv next to pyproject.toml: system libraries with apt-get, Python packages with pip.
#   sh assets/install/install.sh                to use it
#   sh assets/install/install.sh --all-extras   with every optional package: exports, films, live sources, ROS, Rerun, ...
#   sh assets/install/install.sh --tests        to work on it: editable, with the test tools
# On Windows it runs in Git Bash.
set -eu
cd "$(dirname "$0")/../.."
extras="robots"
lists="assets/install/debian-packages.txt"
editable=""
size="1.5 GB"
for option in "$@"; do
    case "$option" in
    --tests)
        extras="$extras,dev"
        lists="$lists assets/install/debian-packages-tests.txt"
        editable="--editable"
        ;;
    --all-extras)
        extras="$extras,menagerie,xacro,live,pyarrow,ros,export,rerun,learning,cluster"
        size="2.4 GB"
        ;;
    *)
        echo "usage: sh assets/install/install.sh [--all-extras] [--tests]" >&2
        exit 2
        ;;
    esac
done

# System libraries: only where apt-get exists, and only those that are missing.
if command -v apt-get >/dev/null 2>&1; then
    missing=""
    # shellcheck disable=SC2086  # the list of files is meant to be split
    for package in $(grep -hv '^#' $lists); do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
    done
    if [ -n "$missing" ]; then
        as_root=""
        [ "$(id -u)" -eq 0 ] || as_root="sudo"
        echo "Installing system libraries:$missing"
        $as_root apt-get update -qq
        # shellcheck disable=SC2086
        DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
    fi
fi

# The folder of executables is named Scripts on Windows.
if [ ! -x .venv/bin/python ] && [ ! -x .venv/Scripts/python.exe ]; then
    python=python3
    "$python" --version >/dev/null 2>&1 || python=python
    if ! "$python" --version >/dev/null 2>&1; then
        echo "Python is not installed. On Debian: apt-get install python3 python3-pip python3-venv" >&2
        exit 1
    fi
    "$python" -m venv .venv
fi
executables=.venv/bin
[ -x "$executables/python" ] || executables=.venv/Scripts
echo "Installing Python packages into .venv (about $size, mostly VTK and Qt)"
"$executables/python" -m pip install --quiet --disable-pip-version-check \
    --constraint assets/install/constraints.txt $editable ".[$extras]"
echo "Installed. Start it with: $executables/tactile-maps"

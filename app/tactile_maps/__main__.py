"""Run the program with ``python -m tactile_maps``, like the command ``tactile-maps``."""

import sys
from importlib import import_module

if __name__ == "__main__":
    # By name, so that this package imports nothing of the window, which lies above it.
    sys.exit(import_module("tactile_widgets.__main__").main())

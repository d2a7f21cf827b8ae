"""Run the program with ``python -m tactile_maps``, like the command ``tactile-maps``."""

import sys
from importlib import import_module

if __name__ == "__main__":
    # Imported by name, because this package must not import the window, which depends on it.
    sys.exit(import_module("tactile_widgets.__main__").main())

from .application import launch, screenshot
from .main_window import MainWindow

__all__ = [
    "MainWindow",
    "launch",
    "screenshot",
]

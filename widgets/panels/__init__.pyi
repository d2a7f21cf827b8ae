from .panel_column import PanelColumn

__all__ = [
    "PanelColumn",
]

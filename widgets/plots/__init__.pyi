from .live_plots import LivePlots
from .work_precision_plot import WorkPrecisionPlot

__all__ = [
    "LivePlots",
    "WorkPrecisionPlot",
]

"""Several controllers side by side, in a window of its own: chosen, run beside the simulation, drawn over each other.

``comparison_setup`` asks which controllers and on what, ``comparison_plots`` and ``metrics_table`` show what came of
it, ``comparison_view`` is all of it together. The process is in ``workers``, what connects it to the window in
``presenters``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""What accuracy costs in time, what each effect costs, and how controllers compare: measured with the code that the
window runs.

Read in this order:

``study``       what a study is (a question, its cases, how one is measured), and running its cases in several processes
``testbeds``    bodies, touches, pressed robots and paths whose truth is known
``sweeps``      the studies themselves, one a file, called as the command line calls them (``map_cost`` is ``study
                map-cost``)
``figures``     curves and bars of a study;  ``report`` writes CSV, JSON and one HTML page;  ``catalogue`` names all
                studies, without loading them
``work_precision``  the same question asked of the user's own skin: settings tried, and error against milliseconds
``stages``      the stages of the program for which it is asked
``ablation``    what each effect of a scene costs, by leaving it out
``controller_comparison``  several controllers on the same stimulus: traces and metrics
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Skins from and for other programs, one format a file; whatever is noticed on the way in is a ``Finding``.

``taxel_set`` is what every format is read into and written from; ``read`` and ``write`` choose the format. ``icub``
(whose lines ``text_rows`` takes apart), ``table``, ``npz``, ``unige_json`` and ``urdf_tactile`` are the formats. A
hand-drawn iCub map is an ``icub_layout``, and ``module_candidates`` proposes what in it may be turned or mirrored.
``foreign_file`` reads bounded and writes whole.
"""

"""Maps for other programs and back: ``obj_uv`` as texture coordinates of a mesh (``obj_file`` reads the lines);
``svg``, ``png`` and ``picture`` for papers; ``unige`` for the University of Genoa's robot skin library.
"""

"""Maps in files and for other programs.

``map_file`` is our own, whole and checked when read; ``obj`` writes and reads a map as texture coordinates of a mesh;
``svg`` and ``png`` are for papers; ``unige`` for the University of Genoa's robot skin library. ``export`` chooses by
the file's ending.
"""

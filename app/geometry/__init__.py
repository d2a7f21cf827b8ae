"""Meshes, poses and points on a surface: what every later folder speaks of.

Values first: ``mesh``, ``pose``, ``surface_point``. Then questions about a mesh: ``topology`` (who touches whom),
``clean`` (what a file's mesh needs before anything native may see it), ``closest`` and ``raycast`` (built once, asked
often). ``wrap`` makes one clean outer surface of any mesh.

A mesh that is to be laid flat as it is goes through ``repair``, which uses ``orient`` (neighbours agree about the
outside), ``split`` (no more than a surface anywhere) and ``flat_faces`` (none without area). ``outer`` says which of
its faces can be seen, ``subdivide`` makes it finer.
"""

"""Pressure between taxels: four ways from the taxels of a patch to any point of its map, each one sparse matrix.

``triangles`` is what they share: the taxels' own triangulation, without the triangles that would bridge a gap, and what
holds beyond its border. Then one file a method, all with the same signature: ``barycentric`` (the default),
``nearest``, ``natural_neighbour``, ``thin_plate``. ``weights`` applies one of them to a whole map, patch by patch.
"""

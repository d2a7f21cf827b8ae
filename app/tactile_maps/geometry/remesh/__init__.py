"""Remeshing: different triangles for the same surface.

``repair``    cleans a file's mesh for native code, or repairs it for flattening
``stitch``    removes T-junctions: divides a coarse face at the vertices of its fine neighbour
``wrap``      computes one clean outer surface of any mesh, at a distance from it
``refine``    adds vertices on the same surface: subdivision, vertices at given points
``simplify``  reduces the triangles over the same vertices and measures the distance from the mesh
"""

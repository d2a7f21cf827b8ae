"""Other triangles for the same surface.

``repair``    a file's mesh cleaned for native code, or repaired to be flattened
``stitch``    T-junctions stitched: a coarse face divided at the vertices of its fine neighbour
``wrap``      one clean outer surface of any mesh, at a distance from it
``refine``    more vertices on the same surface: subdivision, vertices at given points
``simplify``  fewer triangles of the same vertices, and how far they are from the mesh
"""

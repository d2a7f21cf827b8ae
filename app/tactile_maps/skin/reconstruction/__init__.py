"""Surfaces for taxels that come without one.

``reconstruct``    a skin from positions in the frame of a link
``triangulation``  normals and triangles, with an extended boundary
"""

"""Placement of taxels on a surface.

``placement``       number or pitch, pattern, density and zones to keep out of
``patterns``        hexagonal lattice, and triangular modules of ten
``sampling``        evenly distributed taxels
``cells``           cells of taxels: the part of the surface that is nearest to each
``usable_surface``  the part of a wrapped link on which skin can be placed
"""

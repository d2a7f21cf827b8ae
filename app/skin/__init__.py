"""The skin: patches of taxels on links, and the four ways to get one.

Read in this order:

``skin``               taxels, their identity and quadrature, patches, and all of them as one skin: the values
``skin_file``          a skin as npz, checked on reading
``open``               whatever a user has (robot, mesh, taxels, skin, map) becomes a skin
``cover``              a skin that places itself on a robot: links chosen, wrapped, kept clear of joints
``mesh_skin``          a skin right on a bare mesh
``fit``                measured taxel positions fitted to a robot's link
``reconstruct``        a skin from taxels alone: a surface laid through them, its boundary extended
``usable_surface``     where on a wrapped link skin can lie: visible, clear of neighbours, in tidy components
``placement``          the taxels a person asks for on a surface: number or pitch, pattern, density, keep-out zones
``sampling``           the even pattern: farthest-point sampling, Lloyd relaxation, geodesic Voronoi cells
``patterns``           the other two: a hexagonal lattice, and triangular modules as on iCub and CySkin
``triangulation``      normals and triangles of taxels that come without a surface
``calibration_error``  the skin as a calibration with errors would have it
``formats``            taxels in the files of other programs
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

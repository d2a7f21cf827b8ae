"""The skin as a value.

``skin``               taxels with identity and quadrature, patches, and all patches as one skin
``taxel_axes``         number of axes of taxels, and the first tangents of their frames
``skin_file``          skins as npz, checked when they are read
``taxel_set``          taxels as a file states them, before they are on a surface
``touchable_surface``  surface of rigidly joined links that can be touched
``bare_surface``       points on the parts of links that no taxel reads
"""

"""Tactile maps: all patches of a skin on one plane, with the inverse and measures of quality.

``build``            makes a map of a skin: flattens each patch (``tactile_maps.flattening``) and arranges the charts
``model``            the map and its layout, Jacobian, seams, interpolation and tactile image
``paths``            paths that are drawn on the map and continue across seams and patches
``path_on_body``     drawn paths as places on the body, which an edit of the map does not change
``image_atlas``      the tactile image of a running session, one tile for each patch
``pressure_colours`` pressures as colours, without Qt
``evaluation``       distortion, topography, quality and comparison of maps
``formats``          files of maps, and export to other programs
``learned``          maps learned from touch alone
"""

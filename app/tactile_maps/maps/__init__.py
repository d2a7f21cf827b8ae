"""The tactile map: all patches of a skin on one plane, with the way back, and how good it is.

In the order of the work: ``build`` makes a map of a skin, with every patch flattened (``tactile_maps.flattening``) and
the charts arranged (``layout``). ``tactile_map`` goes from the body to the map and back; ``seam_transitions``
continues it over its seams, ``paths`` are drawn on it and laid over seams and patches, ``jacobian`` is its
differential, for control. ``tactile_image`` shows pressures as a picture, by ``interpolation``, and keeps their
force; ``image_atlas`` shows them live, each patch in a tile of its own.

``evaluation`` says how good it is: distortion by face, topography by taxel, two maps side by side.

``formats`` keeps maps in files and takes them to other programs; ``learned`` makes maps from touch alone.
"""

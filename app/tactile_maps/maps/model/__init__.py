"""The tactile map and what is derived from it.

``tactile_map``       one-to-one correspondence of skin and plane, evaluated in both directions
``layout``            placement and packing of patches
``seam_transitions``  continuation of the plane across a seam
``jacobian``          differential of the map, for control
``taxel_frames``      frames of taxels, and their directions on the map
``interpolation``     pressure between taxels, as sparse matrices
``tactile_image``     pressures as a regular grid that conserves force
"""

"""Files of iCub skins.

``positions``           skin positions (.txt)
``frames``              coordinate frames in which such files state positions
``layout``              layout files (.ini): hand-drawn map of a patch
``sensor_kinds``        positions of the pads of each kind of module on such a map
``module_orientation``  modules of such a layout that seem rotated or mirrored, with a proposal for each
"""

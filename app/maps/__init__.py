"""The tactile map: the skin cut, flattened and laid out, with its inverse and its quality.

Read in the order of the work: ``cut`` (a patch becomes a disk), ``tutte`` (a first map that is always valid),
``symmetric_dirichlet`` (the best map near it), ``bijective`` (what "valid" means, checked), ``flatten`` (those four in
a row, giving a ``chart``), ``packing`` (charts become a ``layout``), ``tactile_map`` (body to map and back),
``tactile_image`` (pressures as a picture), ``quality`` (how good it is). ``build`` does all of it, ``map_file`` keeps
the result.
"""

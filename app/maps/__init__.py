"""The tactile map: the skin cut, flattened and laid out, with its inverse and its quality.

Read in the order of the work. One patch: ``cut`` (it becomes a disk), ``tutte`` (a first map that is always valid),
``rest`` (the shapes to keep), ``symmetric_dirichlet`` (the map that keeps them best), ``bijective`` (what valid means,
checked), ``border`` (how a map is kept off itself), ``flatten`` (those in a row, giving a ``chart``). All patches:
``packing`` (charts become a ``layout``), ``tactile_map`` (body to map and back, by ``locate`` on a ``grid``),
``tactile_image`` (pressures as a picture, by ``interpolation``). How good it is: ``geodesics``, ``topography``,
``quality``. ``build`` does all of it, ``map_file`` keeps the result.
"""

"""The tactile map: the skin cut, flattened and laid out, with its inverse and its quality.

Read in the order of the work. ``sources`` opens whatever a user has. One patch: ``cut`` (it becomes a disk), ``seams``
and ``seam_curve`` (where, and what more would gain), ``methods`` (ways to lay a disk flat), ``rest`` (the shapes to
keep), ``symmetric_dirichlet`` (how well they are kept), ``newton`` (the map that keeps them best, on the matrices of
``block_pattern``), ``bijective`` (what valid means, checked), ``border`` (how a map is kept off itself), ``flatten``
(those in a row, giving a ``chart``). All patches: ``packing`` (charts become a ``layout``), ``tactile_map`` (body to
map and back, by ``locate`` on a ``grid``), ``glue`` and ``trace`` (on over a seam), ``tactile_image`` (pressures as a
picture, by ``interpolation``; ``image_force`` keeps its force). ``learned`` makes maps from touch alone.

How good it is: ``distortion`` (faces), ``topography`` (taxels, against ``body_distances`` by ``geodesics`` from the
points of ``insert``), ``image_quality``, all together in ``quality``; ``compare`` sets two maps side by side. ``build``
does all of it, ``map_file`` keeps the result, ``exchange`` takes it to other programs.
"""

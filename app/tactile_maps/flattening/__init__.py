"""Flattening of one patch of skin, one-to-one. In the order of the work:

``cut``                  opens a surface along seams until it is a disk
``initial_map``          prepares it for every method, with a first valid map (Tutte)
``methods``              methods of flattening
``flatten``              runs a method, repairs what is not one-to-one, and proves the result
``chart``                the flattened patch
``symmetric_dirichlet``  energy that is minimized
``newton``               minimizer
``bijectivity``          test of validity, and the barrier that keeps a map from overlapping itself
``pinned_patch``         a patch that follows pins set by a user; ``pin_descent`` minimizes within a frame
``reduced_model``        coarse cage for pins on large patches

Maps of several patches are in ``tactile_maps.maps``.
"""

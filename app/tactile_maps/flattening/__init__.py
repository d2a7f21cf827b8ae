"""One patch of skin from the body to the plane, one-to-one.

Read in the order of the work. ``cut`` opens a surface along seams until it is a disk; ``initial_map`` makes it ready
for any method and gives its first valid map (Tutte); ``methods`` are the ways to flatten it, and ``flatten`` runs one,
mends what is not one-to-one and proves the result, a ``chart``. Under them: ``symmetric_dirichlet`` (the energy that is
minimised), ``newton`` (the minimiser) and ``bijectivity`` (what valid means, checked, and the barrier that keeps a map
off itself).

A patch that is edited by hand is a ``pinned_patch``: it follows its pins within a frame by rounds of ``pin_descent``,
and large patches by the coarse cage of ``reduced_model``.

Nothing here knows a map of several patches; that is ``tactile_maps.maps``.
"""

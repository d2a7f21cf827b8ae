"""Ways of laying a disk flat, one a file, all called alike.

``disk`` is what every method gets: a cut patch of unit area. Each then yields ever better maps of it; whether the last
one is one-to-one is not its business, ``flatten`` looks and mends. ``tutte`` is always valid and the others' start;
``harmonic``, ``lscm``, ``arap`` and ``slim`` are libigl's; ``unroll`` is exact on planes, cylinders and cones;
``balanced`` is our own minimiser and the default. ``table`` names them.
"""

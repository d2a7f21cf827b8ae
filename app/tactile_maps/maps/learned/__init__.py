"""Maps learned from touch: where taxels lie, told from what they feel together, with nothing known of the body.

The other way to a tactile map, to be compared with geometry's. A learned map says which taxels are often touched
together, and that is all it says: two far places that are always pressed together come out as neighbours.

Read in the order of the work. ``readings`` (what was felt, and which taxels never felt anything) makes recorded
pressures fit to learn from. ``embedding`` is the way from distances to places: near neighbours, paths between the rest,
classical scaling and SMACOF. The builders, one a file: ``information_distance``, ``geodesic_information``,
``temporal_correlation``, ``human_touch``, ``self_organising``; ``methods`` names them. A ``learned_map`` becomes a
tactile map like any other in ``as_tactile_map``.
"""

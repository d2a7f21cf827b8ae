"""Maps learned from touch: where taxels lie, told from what they feel together, with nothing known of the body.

The other way to a tactile map, to be compared with geometry's. A learned map says which taxels are often touched
together, and that is all it says: two far places that are always pressed together come out as neighbours.

Read in the order of the work. ``readings`` (what was felt, and which taxels never felt anything) makes recorded
pressures fit to learn from. ``information`` is the distance of information theory, ``correlation`` the likeness of
signals; ``knn_graph`` keeps those distances that can be trusted and completes the rest along paths; ``classical_mds``
and ``smacof`` are the two ways from distances to places, ``placing`` is graph, paths and places in a row; ``lay_open``
puts a surface through points in space, to cut and flatten it. The builders, one a file: ``information_distance``,
``geodesic_information``, ``temporal_correlation``, ``human_touch``, ``self_organising``; ``table`` names them. A
``learned_map`` becomes a tactile map like any other in ``as_map``, with its border found by ``outline``.

``isomap`` belongs here by its method, not by its source: it takes distances over the body, not touch.
"""

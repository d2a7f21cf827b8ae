"""Maps learned from touch, without any geometry of the body; for comparison with geometric maps.

A learned map states only which taxels are often touched together. Two distant places that are always pressed together
become neighbours.

``readings``        prepares recorded pressures: noise, taxels without touch
``embedding``       positions from dissimilarities: near neighbours, shortest paths, classical scaling, SMACOF
``information_distance``, ``geodesic_information``, ``temporal_correlation``, ``human_touch``, ``self_organising``
                    methods; ``methods`` lists them by name
``learned_map``     result of every method
``as_tactile_map``  a learned map as a tactile map
"""

"""Meshes, poses and points on a surface: what every later folder speaks of.

``mesh``            a triangle mesh, and a point on a surface
``pose``            a rigid transform
``plane``           cross products and winding numbers in the plane
``connectivity``    adjacency: edges, boundaries, components, orientation, manifold parts
``remesh``          repaired, wrapped, refined, simplified
``closest_point``   the point of a mesh nearest to another; barycentric weights
``raycast``         the first hit of a ray; the faces seen from outside
``inner_walls``     the inner side of thin shells
``geodesics``       distances over a surface
``surface_grid``    straight walks, and a grid of points between two points of a surface
``point_location``  which triangle of the plane holds a point, among many
``triangle_walk``   the same, from a triangle near by
"""

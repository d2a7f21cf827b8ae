"""Meshes, poses and points on surfaces, the base of all later packages.

``mesh``            a triangle mesh, and a point on a surface
``pose``            a rigid transform
``plane``           cross products and winding numbers in the plane
``connectivity``    adjacency: edges, boundaries, components, orientation, manifold parts
``remesh``          repair, wrap, refine, simplify
``closest_point``   the point of a mesh closest to a query point; barycentric weights
``raycast``         the first hit of a ray; the faces seen from outside
``inner_walls``     the inner side of thin shells
``geodesics``       distances over a surface
``surface_grid``    straight walks, and a grid of points between two points of a surface
``point_location``  the triangle of the plane that contains a point, for many triangles
``triangle_walk``   the same, starting from a nearby triangle
"""

"""Triangle meshes and queries on them: connectivity, closest points, rays and walks."""

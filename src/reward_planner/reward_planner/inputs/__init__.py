"""The ways in: point clouds, depth images, three cameras; each hands on points in the optical frame."""

"""Which small cubes of space hold something: points counted into voxels, and the values of voxels over time."""

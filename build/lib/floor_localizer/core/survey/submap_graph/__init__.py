"""The pose graph of the submaps: sequential edges, loop closures, optimisation."""

"""Edge linking: edges to segments with polylines, chain codes and neighbours (paper 3.4)."""

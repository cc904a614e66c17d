"""Direct alignment of taught planar patches by their grey values (Lucas-Kanade)."""

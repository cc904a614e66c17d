"""Files: map_server maps, routes, reward tables and pictures."""

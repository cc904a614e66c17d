"""Files that are read and written: maps of map_server, routes."""

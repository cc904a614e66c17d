"""A robot sees obstacles with its cameras, maps the free floor and finds the way to its goal."""

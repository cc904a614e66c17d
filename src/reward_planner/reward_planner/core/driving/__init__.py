"""From the map and the goal to velocities: the route is kept, followed and left again as the world demands."""

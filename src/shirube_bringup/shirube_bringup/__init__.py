"""The whole suite drives a simulated robot through a room of unknown obstacles."""

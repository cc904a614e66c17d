"""Rendered worlds with known truth: random-dot floors, a belly camera and a robot's drive."""

"""Collision monitor: limits a commanded velocity by fresh ranges, without map, planner or pose."""

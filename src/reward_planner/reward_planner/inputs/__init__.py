"""Subscriptions to point clouds, depth images or three cameras; each passes on points in the optical frame."""

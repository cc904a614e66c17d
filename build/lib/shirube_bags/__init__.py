"""Bags: written, read, replayed without a loss, recorded, and compared with ground truth."""

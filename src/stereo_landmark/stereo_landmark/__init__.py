"""Teach a place once, come back and know where you stand: two cameras, no markers."""

"""Packets sent by lamps: IDs, data and commands as bytes with checksums."""

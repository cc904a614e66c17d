"""What lamps say: IDs, data and commands as bytes with checksums."""

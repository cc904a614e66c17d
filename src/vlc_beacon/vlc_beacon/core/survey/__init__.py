"""Where lamps hang, from a drive with known poses."""

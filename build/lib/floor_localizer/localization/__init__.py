"""The localizer of a map file with its settings, which node and ``locate`` share; what RViz shows of a result."""

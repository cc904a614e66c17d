"""Match without a prior: constellations of six dots looked up in an index and grown to whole views."""

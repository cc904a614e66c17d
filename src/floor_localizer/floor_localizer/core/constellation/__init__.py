"""Match without a prior: constellations of five dots looked up in an index and grown to whole views."""

"""Reference implementation of the paper's method (Fukase and Kanamori), as a baseline for benchmarks."""

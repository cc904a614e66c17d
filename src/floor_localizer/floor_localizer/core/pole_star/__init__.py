"""The paper's own method (Fukase and Kanamori), written out plainly: the measure for what betters it."""

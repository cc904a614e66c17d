"""Bundle adjustment of all images of a survey, block by block, out of core."""

"""Detection and subpixel refinement of ellipses, quadrilaterals, parallel lines and corners (paper 3.2, 3.3c)."""

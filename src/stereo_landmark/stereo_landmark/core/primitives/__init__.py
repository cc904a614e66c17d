"""Ellipses, quadrilaterals, parallel lines and corners with sub-pixel parameters (paper 3.2, 3.3c)."""

"""Bundle adjustment of all images of a survey, block by block, out of core.

In all modules, ``states`` are x, y [m], yaw [rad], scale, roll, pitch [rad] of all images, shape (k, 6), ``position``
is the optical centre in the base frame, shape (3,) [m], and a ``runner`` runs tasks that see the array store.
"""

"""Five identical meters in a row, alone and with other things: the paper's experiment at a small scale."""

from drawn_wall import Disc, Plate, Wall


def row_of_meters(places, radius=0.09):
    """Return meters at some y [m]."""
    return tuple(Disc(float(y), 0.75, radius, 60.0) for y in places)


METERS = row_of_meters(0.6 - 0.28 * i for i in range(5))
PLATES = (0.0, 0.45, 1.6, 0.12, 90.0), (-0.75, 0.95, 0.2, 0.15, 210.0), (0.9, 0.75, 0.12, 0.3, 200.0)
ALL = Wall((*METERS, *(Plate(*plate) for plate in PLATES)))
ALONE = Wall(METERS)

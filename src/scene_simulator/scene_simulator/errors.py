"""The one exception root of the simulator."""


class SceneError(ValueError):
    """A scene that cannot be built; the message is one line with the reason."""


def check_seed(seed: int) -> None:
    """Refuse with a SceneError a negative seed, which no generator takes."""
    if seed < 0:
        raise SceneError(f'the seed is {seed}: give zero or a positive whole number')

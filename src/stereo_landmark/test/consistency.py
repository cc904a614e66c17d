"""Compares errors with their stated covariance."""

import numpy as np


def mahalanobis(errors, covariance):
    """Return the normalized estimation error squared (NEES) per coordinate; 1 for a consistent covariance."""
    return float(errors @ np.linalg.solve(covariance, errors)) / len(errors)


def whitened_rms(errors, covariance, axis=None):
    """Return the rms of errors over their standard deviations; 1 for a consistent covariance."""
    whitened = np.linalg.inv(np.linalg.cholesky(covariance)) @ np.array(errors)[..., None]
    return np.sqrt(np.mean(whitened**2, axis=axis))

"""`shirube try`: will it work here? From photographs and films, before anything is bought."""

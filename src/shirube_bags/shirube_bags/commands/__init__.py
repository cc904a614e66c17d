"""The executables of shirube_bags."""

"""A table that cannot be made from what is there."""


class Unmade(Exception):
    """Says what is missing; the block stays as it is."""

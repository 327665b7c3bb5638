"""What can be wrong with what a user gives: errors whose message is one line with the remedy."""


class InputError(ValueError):
    """A value cannot be used; the message says why and how to write it."""


class StoreError(Exception):
    """The database cannot be used; the message says why and what to do."""


class WorkError(Exception):
    """Work could not be done by the processes that should do it; the message says why and what to do."""

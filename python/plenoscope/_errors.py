"""What can go wrong, in the sentences of the command line: what, why, and what to do."""


class Error(Exception):
    """Something could not be done; the text says why, and what to do."""


class UsageError(Error, ValueError):
    """Arguments cannot be, or do not go together."""


class FileError(Error, OSError):
    """A file could not be read or written."""


class PlenoscopeWarning(UserWarning):
    """Something was done otherwise than it was asked for; the text says how."""

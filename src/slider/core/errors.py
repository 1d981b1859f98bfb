"""The one error that users see as a single line."""


class UserError(Exception):
    """Bad input from a user: one line that says what was expected and what was found.

    Command-line entry points print it without a trace and exit with status 1.
    """

"""The subcommands of ``slider``."""

from pathlib import Path

from slider.core.errors import UserError


def make_folder(folder: Path) -> None:
    """Create the folder of an ``--out``.

    Raises:
        UserError: it cannot be.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--out: {folder}: {error.strerror}") from None

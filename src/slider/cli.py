"""The command ``slider``: a table of subcommands.

A module with one subcommand has ``add_arguments(parser)`` and ``run(arguments)``; a module with
several has ``NAME_arguments`` and ``NAME`` for each. Only the module of the given command is
imported, so that a gait job does not wait for torch.
"""

import argparse
import importlib
import io
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from slider.artefacts.store import ARTEFACTS
from slider.core.errors import UserError, not_written

COMMANDS = {
    "config": ("slider.commands.config", "print the resolved configuration"),
    "robot": ("slider.commands.robot", "check a robot's file and draw the robot"),
    "play": ("slider.commands.play", "watch a policy, a gait or a random agent"),
    "runs": ("slider.commands.runs", "browse the runs in MLflow"),
    "why": ("slider.commands.plans:why", "show what would be computed, because of which change"),
    "diff": ("slider.commands.plans:diff", "show how two plans or two stores differ"),
    "store": ("slider.commands.store", "verify, clean and share the artefact store"),
    "library": ("slider.commands.library", "show what is in the gait library"),
    "policy": ("slider.commands.policy", "show or export a trained policy"),
    "results": ("slider.commands.results", "fill the documentation's result blocks"),
}
INTERNAL = {
    "run": ("slider.commands.jobs:run", "run one job of a plan"),
    "publish": ("slider.commands.jobs:publish", "copy files of a result out of the store"),
}
"""Commands that only the pipeline calls; not listed in the help."""


class Parser(argparse.ArgumentParser):
    """Argument parser, also of subcommands, whose errors are one-line messages."""

    def error(self, message: str) -> NoReturn:
        """Raise the message.

        Raises:
            UserError: always.
        """
        command = self.prog.removeprefix("slider").strip()
        raise UserError(f"{command}: {message}" if command else message)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one subcommand; bad input results in a one-line message and status 1."""
    _open_streams()
    name, *arguments = list(sys.argv[1:] if argv is None else argv) or ["--help"]
    try:
        if argv is None and name in COMMANDS:
            _require_own_folder()
        if name not in COMMANDS | INTERNAL:
            return _no_command(name)
        if not any(word.startswith("--f") for word in arguments):  # no renderer is needed
            os.environ.pop("MUJOCO_GL", None)
        place, text = (COMMANDS | INTERNAL)[name]
        place, _, function = place.partition(":")
        module = importlib.import_module(place)
        parser = Parser(f"slider {name}", description=text)
        getattr(module, f"{function}_arguments" if function else "add_arguments")(parser)
        code = getattr(module, function or "run")(parser.parse_args(arguments)) or 0
        sys.stdout.flush()
        return code
    except UserError as error:
        line = str(error)
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    except BrokenPipeError:  # the reader has closed the pipe, such as `head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        if error.errno is None:
            raise
        line = str(not_written(error, Path(ARTEFACTS)) or f"{error.filename}: {error.strerror}")
    print(f"slider: {line}", file=sys.stderr)
    return 1


def _require_own_folder() -> None:
    """Reject a checkout other than the installed one: a copied environment runs the original."""
    here, own = Path("src/slider/cli.py"), Path(__file__)
    if here.is_file() and not here.samefile(own):
        found = own.parents[2]
        raise UserError(f"expected slider of this folder, found that of {found}: run `make table1`")


def _open_streams() -> None:
    """Open standard streams that the caller closed (``>&-``), so that no file gets their numbers.

    Characters that the terminal's encoding lacks are shown as ``?``.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            stream = open(os.devnull, mode, encoding="utf-8")  # noqa: SIM115
            os.set_inheritable(stream.fileno(), True)
            setattr(sys, name, stream)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")


def _no_command(name: str) -> int:
    """Show the commands, or reject an unknown one."""
    lines = [f"  {name:<20}{text}" for name, (_, text) in COMMANDS.items()]
    parser = Parser(
        "slider",
        description="Gaits, training and evaluation of the biped SLIDER.",
        epilog="\n".join(["commands:", *lines]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("command", choices=COMMANDS, metavar="command")
    parser.parse_args([name])
    return 1


if __name__ == "__main__":
    sys.exit(main())

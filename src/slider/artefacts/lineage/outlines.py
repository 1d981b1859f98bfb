"""What the working tree would run with some overrides, laid out beside the store."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from slider.artefacts.recipe import SOURCE_ROOT
from slider.artefacts.store import Store
from slider.core.errors import UserError


@contextmanager
def outlines(overrides: Sequence[str], target: str) -> Iterator[list[Store]]:
    """Stores without results, each with the plan of the working tree and some overrides.

    Raises:
        UserError: there is no working tree, or the overrides do not compose.
    """
    root = SOURCE_ROOT.parent
    if not overrides:
        yield []
        return
    if not (root / "pipeline").is_dir():
        raise UserError(f"expected the pipeline beside the package, found none in {root}")
    with tempfile.TemporaryDirectory() as folder:
        stores = [Store(Path(folder) / str(number)) for number in range(len(overrides))]
        pairs = [
            str(x) for pair in zip((s.root for s in stores), overrides, strict=True) for x in pair
        ]
        done = subprocess.run(
            [sys.executable, "-m", "pipeline.outline", Path(target).stem, *pairs],
            cwd=root,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (root, SOURCE_ROOT)))},
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            killed = f"expected a plan, found none: status {done.returncode}"
            raise UserError((done.stderr.strip().splitlines() or [killed])[-1])
        yield stores

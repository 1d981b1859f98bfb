"""Checkpoints of a training: the last two, each with the digest of its content."""

import hashlib
import io
import os
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path
from typing import Any

import torch

CHECKPOINT = "checkpoint.pt"
BEFORE = "checkpoint_before.pt"
_DAMAGED = ".damaged"


def write(content: dict[str, Any], folder: Path) -> None:
    """Put a checkpoint in the place of the last one, which becomes the one before.

    Its bytes are on the disk before its name is: a power cut leaves one of the two whole.
    """
    buffer = io.BytesIO()
    torch.save(content, buffer)
    partial = folder / f"{CHECKPOINT}.partial"
    with partial.open("wb") as file:
        file.write(_digest(buffer.getbuffer()) + b"\n")
        file.write(buffer.getbuffer())
        file.flush()
        os.fsync(file.fileno())
    if (folder / CHECKPOINT).exists():
        (folder / CHECKPOINT).replace(folder / BEFORE)
    partial.replace(folder / CHECKPOINT)


def read(folder: Path, say: Callable[[str], None]) -> dict[str, Any]:
    """The newest whole checkpoint, or nothing.

    Damaged ones are renamed to ``*.damaged``; ``say`` shows one line about each.
    """
    paths = [path for path in (folder / CHECKPOINT, folder / BEFORE) if path.exists()]
    for path, before in zip_longest(paths, paths[1:]):
        content = _content(path)
        if content is not None:
            return content
        path.replace(path.with_name(path.name + _DAMAGED))
        start = "from the one before" if before else "anew"
        say(f"{path} is damaged and set aside: the training starts {start}")
    return {}


def _content(path: Path) -> dict[str, Any] | None:
    """Content of a file; none where it is damaged."""
    try:
        digest, _, data = path.read_bytes().partition(b"\n")
    except OSError:  # such as a failing disk
        return None
    if digest != _digest(data):
        return None
    return torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)


def _digest(data: bytes | memoryview) -> bytes:
    return hashlib.sha256(data).hexdigest().encode()

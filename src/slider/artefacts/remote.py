"""Files below an address, through fsspec: a folder, ssh, S3, or HTTP to read from."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import fsspec
from fsspec.config import conf

from slider.core import files
from slider.core.errors import UserError

MARKER = "slider-store.json"
CONNECTIONS = 16
"""Files that travel at once."""
_LAYOUT = files.canonical({"layout": 3}).encode()
_FOLDERS = ("", "results", "files")
_ABSENT = (403, 410)  # a bucket that may not be listed refuses what it lacks
_S3 = {"connect_timeout": 10, "read_timeout": 60, "retries": {"max_attempts": 2}}
# Hosts of ~/.ssh/known_hosts only: sshfs by itself accepts any.
_SSH = {"known_hosts": (), "connect_timeout": 10, "login_timeout": 10, "keepalive_interval": 20}

for _name, _settings in (("s3", {"config_kwargs": _S3}), ("sftp", _SSH), ("ssh", _SSH)):
    conf[_name] = _settings | conf.get(_name, {})  # those of a user have precedence
for _name in ("sftp", "ssh"):
    fsspec.register_implementation(_name, "sshfs.SSHFileSystem", clobber=True)

T = TypeVar("T")


@dataclass(frozen=True)
class Remote:
    """Files below an address; every failure of the way there is one :class:`UserError`."""

    url: str

    def __post_init__(self) -> None:
        if re.search("://[^/@]*:[^/@]+@", self.url):
            raise UserError(
                "expected a remote without a password in its address: use a key, the environment "
                "or the configuration of fsspec"
            )

    def open(self, create: bool = False) -> bool:
        """Tell whether there is a store of ours; make an empty one if asked.

        Raises:
            UserError: the remote does not answer, or has another store.
        """
        marker = self.read(MARKER)
        if not marker and create:
            with self._files() as (fs, root):
                if "file" in fs.protocol:  # the others need no folders, or make them
                    for name in _FOLDERS:
                        with suppress(FileExistsError):
                            fs.mkdir(f"{root}/{name}", create_parents=False)
            self.write(MARKER, _LAYOUT)
        elif marker and marker != _LAYOUT:
            raise UserError(f"remote {self.url}: expected a store of layout 3, found another")
        return bool(marker) or create

    def read(self, name: str) -> bytes | None:
        """Content of a small file, if it is there."""
        return self._ask(lambda fs, root: fs.cat_file(f"{root}/{name}"))

    def size(self, name: str) -> int | None:
        """Size of a file [bytes], if it is there."""
        return self._ask(lambda fs, root: fs.info(f"{root}/{name}")["size"])

    def get(self, names: Mapping[Path, str]) -> bool:
        """Copy files here, by their places; tell whether all are there."""

        def copy(fs: Any, root: str) -> bool:
            fs.get([f"{root}/{name}" for name in names.values()], [*map(str, names)])
            return True

        return self._ask(copy) or False

    def write(self, name: str, content: bytes) -> None:
        """Write a small file."""
        with self._files() as (fs, root):
            fs.pipe_file(f"{root}/{name}", content)

    def put(self, sources: Mapping[str, Path]) -> None:
        """Copy files there, by their names."""
        with self._files() as (fs, root):
            fs.put([*map(str, sources.values())], [f"{root}/{name}" for name in sources])

    def _ask(self, question: Callable[[Any, str], T]) -> T | None:
        with self._files() as (fs, root):
            try:
                return question(fs, root)
            except Exception as error:
                absent = isinstance(error, FileNotFoundError | PermissionError)
                if absent or getattr(error, "status", None) in _ABSENT:
                    return None
                raise

    @contextmanager
    def _files(self) -> Iterator[tuple[Any, str]]:
        """File system and root; one line for whatever the many libraries behind fsspec raise."""
        try:
            fs, root = fsspec.url_to_fs(self.url)
            fs.invalidate_cache()  # of listings, in which new files lack
            yield fs, root.rstrip("/")
        except Exception as error:
            text = next(iter(str(error).strip().splitlines()), type(error).__name__)
            if isinstance(error, ImportError):
                text += "; for s3, ssh and http: pip install -e '.[remote]' -c constraints.txt"
            raise UserError(f"remote {self.url}: {text}") from None

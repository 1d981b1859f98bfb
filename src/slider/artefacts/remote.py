"""Files below an address, through fsspec: a folder, SSH, S3, or HTTP (read-only).

Files are written atomically: under another name and then renamed, or in one step on S3. Downloads
are limited to the expected size, and only regular files are read.
"""

import json
import tempfile
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

import fsspec
from fsspec.callbacks import Callback
from fsspec.config import conf

from slider.core import files
from slider.core.errors import UserError, not_written

LAYOUT = 3
MARKER = "slider-store.json"
FOLDERS = ("results", "files")
CONNECTIONS = 16
"""Number of parallel transfers."""
_MOVES = ("file", "sftp", "ssh")  # need a rename; the others show a file once it is complete
_READ_ONLY = ("http", "https")
_EXTRA = ("s3", "sftp", "ssh", "http", "https")  # need the extra `remote`
_FORBIDDEN, _GONE = 403, 410
_MARKER_SIZE = 1000  # at most [bytes]
_S3 = {"connect_timeout": 10, "read_timeout": 60, "retries": {"max_attempts": 2}}
# Only hosts of ~/.ssh/known_hosts: by default sshfs accepts any.
_SSH = {"known_hosts": (), "connect_timeout": 10, "login_timeout": 10, "keepalive_interval": 20}

for _name, _settings in (("s3", {"config_kwargs": _S3}), ("sftp", _SSH), ("ssh", _SSH)):
    conf[_name] = _settings | conf.get(_name, {})  # settings of the user take precedence
for _name in ("sftp", "ssh"):
    fsspec.register_implementation(_name, "sshfs.SSHFileSystem", clobber=True)

T = TypeVar("T")


class DamageError(Exception):
    """Content does not match its digest; the text says what was expected and found."""


@dataclass(frozen=True)
class Remote:
    """Files below an address; every failure to reach them is a single :class:`UserError`.

    ``contact_s`` is the timeout of the first request [s].
    """

    url: str
    contact_s: float = 15.0

    def __post_init__(self) -> None:
        try:
            password = urlsplit(self.url).password
        except ValueError as error:  # such as http://[::1
            raise UserError(f"remote {self.url}: {error}") from None
        if password:
            raise UserError(
                "expected a remote without a password in its address: use a key, the environment "
                "or the configuration of fsspec"
            )

    @property
    def _scheme(self) -> str:
        return urlsplit(self.url).scheme or "file"

    def open(self, create: bool = False) -> bool:
        """Tell whether the remote has a store of slider; ``create`` an empty one if asked.

        Raises:
            UserError: the remote does not answer in time, has another kind of store, or is
                read-only where it is to be written.
        """
        if create and self._scheme in _READ_ONLY:
            raise UserError(f"remote {self.url}: expected one to write to, found HTTP")
        answer: Future[bytes | None] = Future()

        def ask() -> None:
            try:
                answer.set_result(self.read(MARKER, _MARKER_SIZE))
            except DamageError:
                answer.set_result(b"")
            except UserError as error:
                answer.set_exception(error)

        # Access to a folder of an unreachable server hangs; a daemon thread does not delay exit.
        threading.Thread(target=ask, daemon=True).start()
        try:
            marker = answer.result(self.contact_s)
        except TimeoutError:
            raise UserError(f"remote {self.url}: no answer within {self.contact_s:g} s") from None
        if marker is None:
            if create:
                self._make_folders()
                self.write(MARKER, files.canonical({"layout": LAYOUT}))
            return create
        with suppress(ValueError, KeyError, TypeError):
            if json.loads(marker)["layout"] == LAYOUT:
                return True
        raise UserError(f"remote {self.url}: expected a store of layout {LAYOUT}, found another")

    def _make_folders(self) -> None:
        if self._scheme == "file":  # the others need none, or make them
            with self._one_line():
                fs, root = fsspec.url_to_fs(self.url)
                for name in ("", *FOLDERS):
                    with suppress(FileExistsError):
                        fs.mkdir(f"{root}/{name}", create_parents=False)

    def read(self, name: str, limit: int) -> bytes | None:
        """Content of a small file, or None if it is missing; raises the errors of ``get``."""
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "copy"
            return copy.read_bytes() if self.get({copy: name}, limit) else None

    def write(self, name: str, text: str) -> None:
        """Write a small file atomically."""
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "text").write_text(text, encoding="utf-8")
            self.put({name: Path(folder) / "text"})

    def size(self, name: str) -> int | None:
        """Size of a file [bytes], or None if it is missing."""
        return self._ask(lambda fs, root: fs.info(f"{root}/{name}")["size"], name)

    def get(self, names: Mapping[Path, str], limit: int) -> bool:
        """Download files, by local path; tell whether the remote has all of them.

        Raises:
            DamageError: one is not a regular file, or together they exceed ``limit`` [bytes], at
                which the copy is aborted.
        """

        def copy(fs: Any, root: str) -> bool:
            paths, targets = [f"{root}/{name}" for name in names.values()], [*map(str, names)]
            if self._scheme in _MOVES:  # the others hold files only
                infos = [fs.info(path) for path in paths]
                if kinds := {info["type"] for info in infos} - {"file"}:
                    raise DamageError(f"expected a file, found another kind: {kinds.pop()}")
                _Limit(limit).relative_update(sum(info["size"] for info in infos))
            try:
                fs.get(paths, targets, callback=_Limit(limit + len(paths)))
            except OSError as error:
                here = error.filename in (None, *targets)
                if here and (line := not_written(error, Path(targets[0]))):
                    raise line from None
                raise
            return True

        return self._ask(copy, *names.values()) or False

    def put(self, sources: Mapping[str, Path]) -> None:
        """Upload files, by remote name, each atomically."""
        with self._one_line():
            fs, root = fsspec.url_to_fs(self.url)  # fsspec keeps one file system per address
            paths = [f"{root.rstrip('/')}/{name}" for name in sources]
            files = [*map(str, sources.values())]
            if self._scheme not in _MOVES:
                fs.put(files, paths)
                return
            parts = [f"{path.rpartition('/')[0]}/.{uuid.uuid4().hex}.part" for path in paths]
            try:
                fs.put(files, parts)
                for part, path in zip(parts, paths, strict=True):
                    fs.mv(part, path)
            except BaseException:
                for part in parts:
                    with suppress(Exception):
                        fs.rm_file(part)
                raise

    def _ask(self, question: Callable[[Any, str], T], *names: str) -> T | None:
        with self._one_line():
            fs, root = fsspec.url_to_fs(self.url)
            fs.invalidate_cache()  # of listings, which lack new files
            try:
                return question(fs, root.rstrip("/"))
            except Exception as error:
                status = getattr(error, "status", None)
                if isinstance(error, FileNotFoundError) or status == _GONE:
                    return None
                # A bucket without permission to list, maybe behind HTTP, answers 403 for a missing
                # file. If the marker can be read, or is that file, the file is just missing.
                refused = isinstance(error, PermissionError) or status == _FORBIDDEN
                bucket = self._scheme in (*_READ_ONLY, "s3")
                if refused and bucket and (MARKER in names or self.size(MARKER) is not None):
                    return None
                raise

    @contextmanager
    def _one_line(self) -> Iterator[None]:
        """Turn errors of fsspec's backends into a ``UserError`` of one line."""
        try:
            yield
        except (UserError, DamageError):
            raise
        except ImportError as error:
            extra = self._scheme in _EXTRA
            text = "pip install -e '.[remote]' -c constraints.txt" if extra else str(error)
            raise UserError(f"remote {self.url}: its kind needs packages: {text}") from None
        except Exception as error:
            lines = str(getattr(error, "strerror", None) or error).strip().splitlines()
            text = lines[0] if lines else type(error).__name__
            raise UserError(f"remote {self.url}: {text}") from None


class _Limit(Callback):
    """Aborts copies that together exceed a limit [bytes], such as an endless response.

    fsspec counts one extra byte per file.
    """

    def __init__(self, limit: int) -> None:
        super().__init__()
        self._limit = limit

    def branched(self, *_: Any, **__: Any) -> Callback:
        """Use one counter for all copies."""
        return self

    def call(self, hook_name: str | None = None, **_: Any) -> None:
        """Compare the bytes received so far with the limit."""
        if self.value > self._limit:
            raise DamageError(f"expected {self._limit} bytes, found more")

"""A place for results that others reach, through fsspec: a folder, ssh, S3, or HTTP to read from.

``results/<recipe>.result.json`` says what a recipe led to and ``archives/<sha256>.tar`` is an
object, so that whoever knows a recipe finds all without a listing, which HTTP has not. A file
becomes visible whole: it is written under another name and moved, or in one step as on S3.
"""

import errno
import json
import threading
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

import fsspec
from fsspec.callbacks import Callback
from fsspec.config import conf

from slider.artefacts.sharing.archive import DamageError
from slider.core import files
from slider.core.disk import not_written
from slider.core.errors import UserError

LAYOUT = 1
MARKER = "slider-store.json"
FOLDERS = ("results", "archives")
CONTACT_S = 15.0
"""Time in which a remote must answer the first question."""

_MOVES = frozenset({"file", "sftp"})  # others show a file when it is whole
_READ_ONLY = frozenset({"http", "https"})
_OURS = frozenset({"s3", "sftp", "ssh", "http", "https"})  # with what the extra `remote` installs
_PATIENCE = {"connect_timeout": 10, "read_timeout": 60, "retries": {"max_attempts": 2}}
_FORBIDDEN, _GONE = 403, 410

conf.setdefault("s3", {}).setdefault("config_kwargs", _PATIENCE)  # that of a user has precedence
for _name in ("sftp", "ssh"):
    fsspec.register_implementation(
        _name, "slider.artefacts.sharing.ssh.KnownHostFileSystem", clobber=True
    )

T = TypeVar("T")
S = TypeVar("S")


@dataclass(frozen=True)
class Remote:
    """Files below an address; every failure of the way there is one :class:`UserError`."""

    url: str
    contact_s: float = field(default=CONTACT_S)

    def __post_init__(self) -> None:
        if urlsplit(self.url).password:
            raise UserError(
                "expected a remote without a password in its address: use a key, the environment "
                "or the configuration of fsspec"
            )

    def check_writable(self) -> None:
        """Refuse a remote that can only be read, whoever asks."""
        with self._told():
            if _protocols(self._place()[0]) & _READ_ONLY:
                raise UserError(f"remote {self.url}: expected one to write to, found HTTP")

    def open(self) -> bool:
        """Tell whether there is a store of ours; a remote that does not answer is an error."""
        found = self._first_answer()
        if found is None:
            return False
        with suppress(ValueError, KeyError, TypeError):
            if json.loads(found)["layout"] == LAYOUT:
                return True
        raise UserError(f"remote {self.url}: expected a store of layout {LAYOUT}, found another")

    def create(self) -> None:
        """Make an empty store."""
        with self._told():
            fs, root = self._place()
            if _protocols(fs) & _MOVES:  # buckets have no folders
                for folder in (root, *(f"{root}/{name}" for name in FOLDERS)):
                    if not fs.exists(folder):
                        with suppress(FileExistsError):  # by another one at this moment
                            fs.mkdir(folder, create_parents=False)
        self.write(MARKER, files.canonical({"layout": LAYOUT}).encode())

    def read(self, name: str) -> bytes | None:
        """Content of a file, if it is there."""
        return self._ask(lambda fs, path: fs.cat_file(path), name)

    def size(self, name: str) -> int | None:
        """Size of a file [bytes], if it is there."""
        return self._ask(lambda fs, path: fs.info(path)["size"], name)

    def fetch(self, name: str, target: Path, size: int) -> bool:
        """Copy a file here; tell whether it is there.

        Raises:
            DamageError: it is larger than a size [bytes]; the copy ends there.
        """

        def copy(fs: Any, path: str) -> bool:
            limit = _Limit(size)
            if not fs.async_impl:  # these copy without a word
                limit.relative_update(fs.info(path)["size"])
            try:
                fs.get_file(path, str(target), callback=limit)
            except OSError as error:
                full = error.errno in (errno.ENOSPC, errno.EDQUOT)  # here: reading fills no disk
                if full and (line := not_written(error, target)):
                    raise line from None
                raise
            return True

        return self._ask(copy, name) or False

    def write(self, name: str, content: bytes) -> None:
        """Write a small file in one visible step."""
        self._put(lambda fs, path: fs.pipe_file(path, content), name)

    def send(self, source: Path, name: str) -> None:
        """Copy a file there in one visible step."""
        self._put(lambda fs, path: fs.put_file(str(source), path), name)

    def in_order(self, work: Callable[[S], T], items: list[S]) -> Iterator[T]:
        """Results of some work for all items, several at a time, in the order of the items."""
        with self._told():
            fs, _ = self._place()
        workers = 16 if fs.async_impl else 4  # what is not asynchronous has a connection each
        with ThreadPoolExecutor(workers) as pool:
            try:
                yield from pool.map(work, items)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def _place(self) -> tuple[fsspec.AbstractFileSystem, str]:
        """File system and path; fsspec keeps one per address, and thread where it must."""
        fs, path = fsspec.url_to_fs(self.url)
        return fs, path.rstrip("/")

    def _ask(self, question: Callable[[Any, str], T], name: str) -> T | None:
        with self._told():
            fs, root = self._place()
            fs.invalidate_cache()  # of listings, in which new files lack
            try:
                return question(fs, f"{root}/{name}")
            except Exception as error:
                if _is_absence(error) or self._is_unlisted(error, fs, name):
                    return None
                raise

    def _is_unlisted(self, error: Exception, fs: Any, name: str) -> bool:
        """Tell whether a bucket that may not be listed, maybe behind HTTP, refuses what it lacks.

        It still gives the marker, unless it is that which it lacks.
        """
        refused = isinstance(error, PermissionError) or getattr(error, "status", None) == _FORBIDDEN
        buckets = _protocols(fs) & (_READ_ONLY | {"s3"})
        return refused and bool(buckets) and (name == MARKER or self.read(MARKER) is not None)

    def _put(self, write: Callable[[Any, str], object], name: str) -> None:
        with self._told():
            fs, root = self._place()
            if not _protocols(fs) & _MOVES:
                write(fs, f"{root}/{name}")
                return
            folder, _, file = f"{root}/{name}".rpartition("/")
            part = f"{folder}/.{file}.{uuid.uuid4().hex[:12]}.part"
            try:
                write(fs, part)
                fs.mv(part, f"{folder}/{file}")
            except BaseException:
                with suppress(Exception):
                    fs.rm_file(part)
                raise

    def _first_answer(self) -> bytes | None:
        """The marker; a remote may hang, as a folder of a server that is switched off does."""
        answer: Future[bytes | None] = Future()

        def ask() -> None:
            try:
                answer.set_result(self.read(MARKER))
            except UserError as error:
                answer.set_exception(error)

        threading.Thread(target=ask, daemon=True).start()  # that of a pool would outlive the wait
        try:
            return answer.result(self.contact_s)
        except TimeoutError:
            raise UserError(f"remote {self.url}: no answer within {self.contact_s:g} s") from None

    @contextmanager
    def _told(self) -> Iterator[None]:
        """One line for whatever the many libraries behind fsspec raise."""
        try:
            yield
        except (UserError, DamageError):
            raise
        except ImportError as error:
            ours = urlsplit(self.url).scheme in _OURS
            text = "pip install -e '.[remote]' -c constraints.txt" if ours else str(error)
            raise UserError(f"remote {self.url}: its kind needs packages: {text}") from None
        except Exception as error:
            lines = str(getattr(error, "strerror", None) or error).strip().splitlines()
            text = lines[0] if lines else type(error).__name__
            raise UserError(f"remote {self.url}: {text}") from None


def _protocols(fs: fsspec.AbstractFileSystem) -> set[str]:
    return {fs.protocol} if isinstance(fs.protocol, str) else set(fs.protocol)


def _is_absence(error: Exception) -> bool:
    return isinstance(error, FileNotFoundError) or getattr(error, "status", None) == _GONE


class _Limit(Callback):
    """Ends a copy that grows beyond a size [bytes], as an endless answer does."""

    def __init__(self, size: int) -> None:
        super().__init__(size)
        self._limit = size

    def relative_update(self, inc: int = 1) -> None:
        super().relative_update(inc)
        if self.value > self._limit:
            raise DamageError(f"expected {self._limit} bytes, found more")

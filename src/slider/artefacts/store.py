"""The artefact store: objects named by their content, manifests named by their recipe.

``objects/<ab>/<sha256>/`` holds the files of one result and ``<stage>/<recipe>.json`` names the
object that a recipe produced. A result is computed in ``objects/tmp/`` and renamed into place, then
its manifest is written: after a crash or power failure, every manifest refers to a complete object.
Each use of an object compares its content with its name: it counts as damaged only if these
differ, not if it cannot be read.

``locks/`` holds lock files: one job per recipe, and no clean-up while jobs run. The operating
system releases the locks when a process ends, even if it is killed.
"""

import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from slider.artefacts.manifest import (
    Manifest,
    Result,
    damaged,
    parse_manifest,
    plain_manifest,
    readable,
)
from slider.artefacts.run_metadata import validate_metadata
from slider.core import files
from slider.core.errors import UserError, not_read

ARTEFACTS = "artefacts"
_GATE = "all"  # held by whoever holds all locks, so that no new one is taken


@dataclass(frozen=True)
class Store:
    """The store below a folder such as ``artefacts/``."""

    root: Path

    @property
    def locks(self) -> Path:
        """Folder of the locks between processes."""
        return self.root / "locks"

    @property
    def tmp(self) -> Path:
        """Folder of unfinished results."""
        return self.root / "objects" / "tmp"

    def object_folder(self, digest: str) -> Path:
        """Folder of an object."""
        return self.root / "objects" / digest[:2] / digest

    def manifest_path(self, stage: str, recipe: str) -> Path:
        """File that names the object that a recipe produced."""
        return self.root / stage / f"{recipe}.json"

    def metadata_path(self, stage: str, recipe: str) -> Path:
        """File with the run metadata of a manifest: what differs from run to run."""
        return self.root / stage / f"{recipe}.run.json"

    def metadata(self, stage: str, recipe: str) -> dict[str, Any]:
        """Run metadata of a manifest; empty where they are missing or damaged."""
        with suppress(OSError, ValueError):
            return validate_metadata(files.read_json(self.metadata_path(stage, recipe)))
        return {}

    def log_path(self, stage: str, recipe: str) -> Path:
        """Log of the latest job of a recipe."""
        return self.root / "logs" / stage / f"{recipe}.log"

    def metrics_path(self, stage: str, recipe: str) -> Path:
        """Metrics of the latest job of a recipe, a line for each step."""
        return self.root / "logs" / stage / f"{recipe}.jsonl"

    def work_folder(self, stage: str, recipe: str) -> Path:
        """Folder that survives a killed job, for checkpoints."""
        return self.root / "work" / stage / recipe

    def cache_folder(self, code: str) -> Path:
        """Folder that jobs of the same source and versions share; it may vanish at any time."""
        return self.root / "cache" / code

    def progress_path(self, stage: str, recipe: str) -> Path:
        """File with the latest progress line of a running job."""
        return self.work_folder(stage, recipe) / "progress.txt"

    @contextmanager
    def temporary(self, name: str) -> Iterator[Path]:
        """Empty folder on the file system of the objects, removed at the end."""
        self.tmp.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f"{name}-", dir=self.tmp))
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def publish(self, folder: Path, summary: dict[str, Any]) -> Result:
        """Sync a finished temporary folder to disk and rename it atomically to its object folder.

        Raises:
            NotReadError: the object folder exists already and cannot be read.
        """
        table = files.file_table(folder)
        result = Result(files.digest_table(table), table, files.plain(summary))
        for name in table:
            (folder / name).chmod(0o444)
        target = self.object_folder(result.object)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copymode(target.parent, folder)  # mkdtemp makes it private
        files.sync(*(path for path in folder.rglob("*")), folder)
        if target.exists() and not self.is_intact(result.object):
            self.drop_object(result.object)
        try:
            folder.rename(target)
        except OSError:
            if not target.is_dir():  # else the same content is there already
                raise
        files.sync(target.parent, target.parent.parent)
        return result

    def is_intact(self, digest: str) -> bool:
        """Read an object; tell whether its content matches its name.

        Raises:
            NotReadError: it exists, but cannot be read.
        """
        folder = self.object_folder(digest)
        try:
            return files.digest_table(files.file_table(folder)) == digest
        except (FileNotFoundError, NotADirectoryError, ValueError):
            return False
        except OSError as error:
            raise not_read(error, folder) from None

    def drop_object(self, digest: str) -> None:
        """Remove an object in place: a folder of a container's lower layer cannot be renamed."""
        folder = self.object_folder(digest)
        if folder.is_dir() and not folder.is_symlink():
            shutil.rmtree(folder)
        else:
            folder.unlink(missing_ok=True)

    def write_manifest(self, manifest: Manifest) -> None:
        """Write the manifest of a recipe; its object is already in place."""
        path = self.manifest_path(manifest.stage, manifest.recipe)
        files.write_json(path, plain_manifest(manifest))

    def read_manifest(self, stage: str, recipe: str) -> Manifest:
        """Manifest of a recipe; raises the errors of ``parse_manifest``."""
        return parse_manifest(self.manifest_path(stage, recipe))

    def manifests(self) -> list[Path]:
        """Paths of all manifests of the store."""
        stages = (p for p in files.entries(self.root) if not p.is_file() and p.name != "plans")
        return _named(stages, r"[0-9a-f]{64}\.json")

    def objects(self) -> list[str]:
        """Digests of all objects, intact or not."""
        groups = _named([self.root / "objects"], "[0-9a-f]{2}")
        return [path.name for path in _named(groups, "[0-9a-f]{64}")]

    def mentioning(self, text: str) -> list[Manifest]:
        """Manifests that contain a text, such as the digest of a file."""
        paths = (path for path in self.manifests() if text in path.read_text("utf-8", "replace"))
        return [manifest for manifest in map(readable, paths) if manifest]

    def index_path(self, key: str) -> Path:
        """Index entry of a key, for early cut-off: the first manifest with this key."""
        return self.root / "index" / key[:2] / f"{key}.json"

    def put_index(self, key: str, manifest: Manifest) -> None:
        """Add a computed result to the index.

        A recipe covers the recipes of the inputs, a key their contents: after a refactoring that
        does not change these contents, the recipe differs, but the key does not.
        """
        files.write_json(self.index_path(key), plain_manifest(replace(manifest, key=key)))

    def find(self, key: str) -> Manifest | None:
        """Manifest of the first job with a key, if its object is intact."""
        return self._whole(self.index_path(key))

    def verify(self, stage: str, recipe: str) -> Manifest | None:
        """Manifest of a recipe, if its object is intact."""
        return self._whole(self.manifest_path(stage, recipe))

    def _whole(self, path: Path) -> Manifest | None:
        manifest = readable(path)
        return manifest if manifest and self.is_intact(manifest.result.object) else None

    def require(self, stage: str, recipe: str) -> Manifest:
        """Manifest of a recipe, after a check that its object is intact.

        Raises:
            UserError: there is none, or its object is damaged.
        """
        manifest = self.read_manifest(stage, recipe)
        if not self.is_intact(manifest.result.object):
            raise damaged(stage, manifest.result.object)
        return manifest


def _named(folders: Iterable[Path], pattern: str) -> list[Path]:
    """Entries of the given folders whose names match a pattern, sorted per folder."""
    paths = (path for folder in folders for path in files.entries(folder))
    return [path for path in paths if re.fullmatch(pattern, path.name)]


@contextmanager
def exclusive(folder: Path, name: str, timeout: float = -1) -> Iterator[None]:
    """Hold the lock of a name; wait while another process holds it, or holds all locks.

    Raises:
        Timeout: another process still holds the lock after ``timeout`` seconds; -1 waits forever.
    """
    with _held(folder, name, timeout):
        with _held(folder, _GATE):
            pass
        try:
            yield
        finally:
            (folder / f"{name}.lock").unlink(missing_ok=True)  # a process that waits notices


@contextmanager
def exclusive_store(folder: Path) -> Iterator[None]:
    """Hold every lock at once.

    Raises:
        UserError: a job is running.
    """
    with ExitStack() as held:
        try:
            held.enter_context(_held(folder, _GATE, timeout=0))
            for path in folder.glob("*.lock"):
                if path.stem != _GATE:
                    held.enter_context(_held(folder, path.stem, timeout=0))
                    held.callback(path.unlink, missing_ok=True)  # left by a killed job
        except Timeout:
            raise UserError(f"expected no running job in {folder.parent}, found one") from None
        yield


def _held(folder: Path, name: str, timeout: float = -1) -> AbstractContextManager[Any]:
    folder.mkdir(parents=True, exist_ok=True)
    return FileLock(folder / f"{name}.lock", timeout).acquire()

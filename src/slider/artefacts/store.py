"""The artefact store: objects named by their content, manifests named by their recipe.

``objects/<ab>/<sha256>/`` holds the files of one result and ``<stage>/<recipe>.json`` names the
object that a recipe led to. A result is computed in ``tmp/`` and renamed into place, then its
manifest is written: whatever is visible is whole, whenever a process dies.

``locks/`` keeps processes apart: one job per recipe, and no clean-up while jobs run. The operating
system releases them when a process ends, however it does.
"""

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
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
from slider.core import files
from slider.core.errors import UserError

ARTEFACTS = "artefacts"
_GATE = "all"  # whoever holds every lock keeps this one, so that no new one is taken


@dataclass(frozen=True)
class Store:
    """The store below a folder such as ``artefacts/``."""

    root: Path

    @property
    def locks(self) -> Path:
        """Folder of the locks between processes."""
        return self.root / "locks"

    def object_folder(self, digest: str) -> Path:
        """Folder of an object."""
        return self.root / "objects" / digest[:2] / digest

    def manifest_path(self, stage: str, recipe: str) -> Path:
        """File that names the object that a recipe led to."""
        return self.root / stage / f"{recipe}.json"

    def sidecar_path(self, stage: str, recipe: str) -> Path:
        """File with what differs from run to run: times, load."""
        return self.root / stage / f"{recipe}.run.json"

    def facts(self, stage: str, recipe: str) -> dict[str, Any]:
        """Read the sidecar of a manifest; empty where that is missing or damaged."""
        try:
            facts = files.read_json(self.sidecar_path(stage, recipe))
        except (OSError, ValueError):
            return {}
        return facts if isinstance(facts, dict) else {}

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
        """Empty folder on the store's file system, removed at the end."""
        parent = self.root / "tmp"
        parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f"{name}-", dir=parent))
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def publish(self, folder: Path, summary: dict[str, Any]) -> Result:
        """Rename a finished folder of this file system atomically to the place of its content."""
        table = files.file_table(folder)
        result = Result(files.digest_table(table), table, files.plain(summary))
        for name in table:
            (folder / name).chmod(0o444)
        folder.chmod(0o755)  # mkdtemp makes it private
        target = self.object_folder(result.object)
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists() and not self.is_whole(result.object):
            self.drop_object(result.object)
        try:
            folder.rename(target)
        except OSError:
            if not target.is_dir():  # else the same content is there already: ours is not needed
                raise
        return result

    def is_whole(self, digest: str) -> bool:
        """Read an object; tell whether its content has its name."""
        folder = self.object_folder(digest)
        try:
            return folder.is_dir() and files.digest_table(files.file_table(folder)) == digest
        except (OSError, ValueError):
            return False

    def drop_object(self, digest: str) -> None:
        """Remove an object in one visible step."""
        folder = self.object_folder(digest)
        if folder.exists():
            with self.temporary("discarded") as grave:
                folder.rename(grave / "object")

    def write_manifest(self, manifest: Manifest) -> None:
        """Write the manifest of a recipe; its object is already in place."""
        path = self.manifest_path(manifest.stage, manifest.recipe)
        files.write_json(path, plain_manifest(manifest))

    def read_manifest(self, stage: str, recipe: str) -> Manifest:
        """Manifest of a recipe; errors as of ``parse_manifest``."""
        return parse_manifest(self.manifest_path(stage, recipe))

    def manifests(self) -> list[Path]:
        """Every manifest of the store."""
        paths = self.root.glob("*/" + "[0-9a-f]" * 64 + ".json")
        return sorted(path for path in paths if path.parent.name != "plans")

    def mentioning(self, text: str) -> list[Manifest]:
        """Manifests that contain a text, such as the digest of a file."""
        paths = (path for path in self.manifests() if text in path.read_text("utf-8", "replace"))
        return [manifest for manifest in map(readable, paths) if manifest]

    def index_path(self, key: str) -> Path:
        """File of the index behind the early cut-off: the first manifest of a key."""
        return self.root / "index" / key[:2] / f"{key}.json"

    def index(self) -> list[Path]:
        """Every entry of the index."""
        return sorted((self.root / "index").glob("*/*.json"))

    def remember(self, key: str, manifest: Manifest) -> None:
        """Add a computed result to the index.

        A recipe holds the recipes of the inputs, a key their contents: after a refactoring that
        leaves these as they were, recipes differ, keys do not.
        """
        files.write_json(self.index_path(key), plain_manifest(replace(manifest, key=key)))

    def present(self, path: Path) -> Manifest | None:
        """A manifest, if its object is there, whole or not."""
        manifest = readable(path)
        there = manifest and self.object_folder(manifest.result.object).is_dir()
        return manifest if there else None

    def indexed(self, key: str) -> Manifest | None:
        """Manifest of the first job with a key, if its object is whole."""
        manifest = readable(self.index_path(key))
        return manifest if manifest and self.is_whole(manifest.result.object) else None

    def whole(self, stage: str, recipe: str) -> Manifest | None:
        """Manifest of a recipe, if its object is whole."""
        manifest = readable(self.manifest_path(stage, recipe))
        return manifest if manifest and self.is_whole(manifest.result.object) else None

    def checked(self, stage: str, recipe: str) -> Manifest:
        """Manifest of a recipe, whose object is whole at this moment.

        Raises:
            UserError: there is none, or its object is damaged.
        """
        manifest = self.read_manifest(stage, recipe)
        if not self.is_whole(manifest.result.object):
            raise damaged(stage, manifest.result.object)
        return manifest

    def drop_dangling(self, paths: Sequence[Path]) -> list[Path]:
        """Remove the manifests whose object is gone; list them."""
        dropped = [path for path in paths if path.is_file() and self.present(path) is None]
        for path in dropped:
            path.unlink(missing_ok=True)
        return dropped


@contextmanager
def exclusive(folder: Path, name: str, timeout: float = -1) -> Iterator[None]:
    """Hold the lock of a name; wait until no other process holds it, nor all locks.

    Raises:
        Timeout: another process still holds the name after so many seconds; -1 waits for ever.
        UserError: there is no place for a lock file.
    """
    with _held(folder, name, timeout):
        with _held(folder, _GATE):
            pass
        try:
            yield
        finally:
            (folder / f"{name}.lock").unlink(missing_ok=True)  # a process that waits notices


@contextmanager
def nobody_else(folder: Path) -> Iterator[None]:
    """Hold every lock at once.

    Raises:
        UserError: some job is running, or there is no place for a lock file.
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
    path = folder / f"{name}.lock"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return FileLock(path, timeout).acquire()
    except Timeout:  # an OSError, too
        raise
    except (OSError, NotImplementedError) as error:
        reason = getattr(error, "strerror", "a file system without locks")
        raise UserError(f"expected a lock file at {path}, found: {reason}") from None

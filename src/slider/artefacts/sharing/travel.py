"""Results that travel: push them to a remote, pull those of others into the store.

Whatever arrives is compared with its digest before the store takes it. A result counts for a
recipe only where its inputs are, byte for byte, those that it was computed from; elsewhere it
waits in the index of the store until such inputs are computed.
"""

import json
import uuid
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider.artefacts.locks import Timeout, exclusive
from slider.artefacts.manifest import Manifest, manifest_from, plain_manifest
from slider.artefacts.plan import JobSpec
from slider.artefacts.sharing.archive import DamageError, pack, packed_size, unpack
from slider.artefacts.sharing.remote import Remote
from slider.artefacts.store import Store
from slider.core import files
from slider.core.errors import UserError

Jobs = Mapping[str, JobSpec]
"""Jobs by recipe, inputs first."""


@dataclass
class Account:
    """Numbers of results by what became of them, bytes that travelled, damage in words."""

    counts: dict[str, int] = field(default_factory=dict)
    size: int = 0
    damage: list[str] = field(default_factory=list)

    def note(self, outcome: str, size: int = 0) -> None:
        """Count one result."""
        self.counts[outcome] = self.counts.get(outcome, 0) + 1
        self.size += size

    def __str__(self) -> str:
        counts = ", ".join(f"{number} {outcome}" for outcome, number in self.counts.items())
        return f"{counts or 'nothing to do'} ({self.size / 1e6:.1f} MB)"


@dataclass(frozen=True)
class _Shared:
    """What is known of a result: its manifest and what is noted beside it."""

    manifest: Manifest
    facts: dict[str, Any]

    def text(self) -> bytes:
        content = {"manifest": plain_manifest(self.manifest), "facts": self.facts}
        return files.canonical({"sha256": files.digest_value(content), **content}).encode()


def push(store: Store, jobs: Jobs, remote: Remote, verify: bool = False) -> Account:
    """Send the results of some jobs that are here and not there; never remove or replace a result.

    Args:
        store: where they are.
        jobs: whose results.
        remote: where to.
        verify: read what is there, and replace what is damaged, in place of looking at its size.

    Raises:
        UserError: the remote does not answer or cannot be written.
    """
    remote.check_writable()
    if not remote.open():
        remote.create()
    account = Account()
    with _no_clean_up(store):
        for outcome, size, damage in remote.in_order(
            lambda job: _push(store, job, remote, verify), list(jobs.values())
        ):
            account.note(outcome, size)
            account.damage += damage
    return account


def pull(store: Store, jobs: Jobs, remote: Remote) -> Account:
    """Take the results of some jobs that are there and not here.

    Args:
        store: where to.
        jobs: whose results; their manifests are written in this order.
        remote: where from.

    Raises:
        UserError: the remote does not answer, or there is no place for what it has.
    """
    account = Account()
    missing = [job for job in jobs.values() if store.whole(job.stage, job.recipe) is None]
    if not missing:
        return account
    if not remote.open():
        raise UserError(f"remote {remote.url}: expected results of slider, found none")
    with _no_clean_up(store):
        answers = remote.in_order(lambda job: _fetch(store, job, remote), missing)
        for job, (found, size, damage) in zip(missing, answers, strict=True):
            if found is None:
                account.note("damaged" if damage else "not there", size)
                account.damage += damage
            else:
                account.note(_accept(store, job, found, remote.url), size)
    return account


def _no_clean_up(store: Store) -> AbstractContextManager[None]:
    return exclusive(store.locks, f"travel-{uuid.uuid4().hex[:12]}")


def _push(store: Store, job: JobSpec, remote: Remote, verify: bool) -> tuple[str, int, list[str]]:
    own = _own(store, job)
    if own is None:
        return "not here", 0, []
    if not store.is_whole(own.manifest.result.object):
        text = "damaged here: run `slider store verify`"
        return "damaged", 0, [f"{job.label} ({job.recipe[:12]}): {text}"]
    there = _there(job, remote)
    if isinstance(there, _Shared) and _has_archive(store, remote, there.manifest, verify):
        same = there.manifest.result == own.manifest.result
        return "already there" if same else "different there", 0, []
    size = _send_archive(store, own.manifest, remote, verify)
    remote.write(_result_name(job), own.text())
    return "sent", size, []


def _own(store: Store, job: JobSpec) -> _Shared | None:
    """A result of this store, if it is known from which contents it was computed."""
    manifest = store.usable(store.manifest_path(job.stage, job.recipe))
    if manifest is None or manifest.input_objects.keys() != job.inputs.keys():
        return None
    return _Shared(manifest, store.facts(job.stage, job.recipe))


def _there(job: JobSpec, remote: Remote) -> _Shared | DamageError | None:
    """What the remote says of a job's result."""
    content = remote.read(_result_name(job))
    if content is None:
        return None
    try:
        values = json.loads(content)
        found = _Shared(manifest_from(values["manifest"]), values["facts"])
        told = (found.manifest.stage, found.manifest.recipe, found.manifest.inputs)
        whole = found.text() == content and told == (job.stage, job.recipe, job.input_recipes)
        checked = found.manifest.input_objects.keys() == job.inputs.keys()
        if whole and checked and isinstance(found.facts, dict):
            return found
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    return DamageError("expected what is known of the result, found something else")


def _has_archive(store: Store, remote: Remote, manifest: Manifest, verify: bool) -> bool:
    if not verify:
        return remote.size(_archive_name(manifest)) == packed_size(manifest.result.files)
    try:
        with _received(store, manifest, remote):
            return True
    except DamageError:
        return False


@contextmanager
def _received(store: Store, manifest: Manifest, remote: Remote) -> Iterator[Path]:
    """Content of an archive in a folder of the store, compared with its name.

    Raises:
        DamageError: there is none, or it is not what its name says.
    """
    table = manifest.result.files
    with store.temporary("travel") as folder:
        archive, content = folder / "archive", folder / "content"
        content.mkdir()
        if not remote.fetch(_archive_name(manifest), archive, packed_size(table)):
            raise DamageError("expected its archive, found none")
        unpack(archive, table, content)
        yield content


def _send_archive(store: Store, manifest: Manifest, remote: Remote, verify: bool) -> int:
    """Send an object if it is not there; tell how many bytes went."""
    if _has_archive(store, remote, manifest, verify):
        return 0
    with store.temporary("push") as folder:
        archive = folder / "archive"
        pack(store.object_folder(manifest.result.object), manifest.result.files, archive)
        remote.send(archive, _archive_name(manifest))
        return archive.stat().st_size


def _fetch(store: Store, job: JobSpec, remote: Remote) -> tuple[_Shared | None, int, list[str]]:
    """Bring the object of a job's result into the store, if the remote has it whole."""
    try:
        found = _there(job, remote)
        if isinstance(found, DamageError):
            raise found
        if found is None:
            return None, 0, []
        return found, _fetch_object(store, found.manifest, remote), []
    except DamageError as error:
        return None, 0, [f"{job.label} ({job.recipe[:12]}): damaged in {remote.url}: {error}"]


def _fetch_object(store: Store, manifest: Manifest, remote: Remote) -> int:
    """Publish an object after its content was compared with its name; tell how many bytes came."""
    result = manifest.result
    if store.is_whole(result.object):
        return 0
    with _received(store, manifest, remote) as content:
        store.publish(content, result.summary, result.resumed)
    return packed_size(result.files)


def _accept(store: Store, job: JobSpec, found: _Shared, origin: str) -> str:
    """Write what leads to an object, unless a job computes the result or did so meanwhile."""
    try:
        with exclusive(store.locks, job.recipe, timeout=0):
            if (own := store.whole(job.stage, job.recipe)) is None:
                return "taken" if _write(store, job, found, origin) else "of other inputs"
    except Timeout:
        return "computed here"
    return "taken" if own.result.object == found.manifest.result.object else "computed here"


def _write(store: Store, job: JobSpec, found: _Shared, origin: str) -> bool:
    """Tell whether an object is now the result of the job's recipe."""
    manifest = found.manifest
    key = job.key(manifest.input_objects)
    if store.known(key) is None:
        store.remember(key, manifest)
    waiting = _input_objects(store, job) != manifest.input_objects
    facts = found.facts | {"computed": False, "taken_from": origin, "waiting": waiting}
    files.write_json(store.sidecar_path(job.stage, job.recipe), facts)
    if not waiting:
        store.write_manifest(manifest)
    return not waiting


def _input_objects(store: Store, job: JobSpec) -> dict[str, list[str]] | None:
    """Objects of a job's inputs that are here, unless one is missing."""
    found = {
        name: [store.usable(store.manifest_path(item.stage, item.recipe)) for item in jobs]
        for name, jobs in job.inputs.items()
    }
    if not all(all(manifests) for manifests in found.values()):
        return None
    return {name: [m.result.object for m in manifests if m] for name, manifests in found.items()}


def _result_name(job: JobSpec) -> str:
    return f"results/{job.recipe}.result.json"


def _archive_name(manifest: Manifest) -> str:
    return f"archives/{manifest.result.object}.tar"

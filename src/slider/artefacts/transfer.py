"""Transfer of results: push them to a remote, pull those of others into the store.

``results/<recipe>.json`` holds the manifest of a recipe and ``files/<sha256>`` one file of an
object, so that no directory listing is needed, which plain HTTP does not offer. The digest of each
download is verified before the store accepts it; file names come from the manifest. A result is
accepted for a recipe only if the local inputs are byte for byte those that it was computed from;
otherwise it stays in the index of the store until such inputs are computed.
"""

import json
import shutil
import uuid
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from slider.artefacts.manifest import Manifest, Result, manifest_from, plain_manifest, readable
from slider.artefacts.plan import JobSpec
from slider.artefacts.remote import CONNECTIONS, DamageError, Remote
from slider.artefacts.run_metadata import validate_metadata
from slider.artefacts.store import Store, Timeout, exclusive
from slider.core import files
from slider.core.errors import UserError
from slider.core.files import FileEntry

Jobs = Mapping[str, JobSpec]
"""Jobs by recipe, inputs first."""
Shared = tuple[Manifest, Mapping[str, Any]]
"""A result in a remote: its manifest and run metadata."""
_METADATA = "run_metadata"  # key of the run metadata in the JSON of a manifest
_RESULT_SIZE = 16_000_000  # maximum size of a manifest [bytes]


@dataclass
class TransferReport:
    """Number of results by outcome, transferred bytes, lines about damage."""

    counts: Counter[str] = field(default_factory=Counter)
    size: int = 0
    damage: list[str] = field(default_factory=list)

    def add(self, outcome: str, size: int = 0) -> None:
        """Count one result."""
        self.counts[outcome] += 1
        self.size += size

    def add_damaged(self, job: JobSpec, text: str) -> None:
        """Count a damaged result and describe the damage."""
        self.add("damaged")
        self.damage.append(f"{job.label} ({job.recipe[:12]}): damaged {text}")

    def __str__(self) -> str:
        counts = ", ".join(f"{number} {outcome}" for outcome, number in self.counts.items())
        return f"{counts or 'nothing to do'} ({self.size / 1e6:.1f} MB)"


def push(store: Store, jobs: Jobs, remote: Remote, force: bool = False) -> TransferReport:
    """Upload results that the remote lacks; never overwrite intact ones.

    With ``force``, upload all and overwrite.

    Raises:
        UserError: the remote does not answer or cannot be written.
    """
    remote.open(create=True)
    report = TransferReport()
    with _no_clean_up(store), ThreadPoolExecutor(CONNECTIONS) as pool:
        outcomes = pool.map(partial(_push, store, remote, force), jobs.values())
        for job, (outcome, size) in zip(jobs.values(), outcomes, strict=True):
            if outcome == "damaged":
                report.add_damaged(job, "here: run `slider store verify`")
            else:
                report.add(outcome, size)
    return report


def pull(store: Store, jobs: Jobs, remote: Remote) -> TransferReport:
    """Download results that the store lacks, inputs first.

    Raises:
        UserError: the remote does not answer or has no store, or results cannot be written here.
    """
    report = TransferReport()
    missing = [job for job in jobs.values() if store.verify(job.stage, job.recipe) is None]
    if not missing:
        return report
    if not remote.open():
        raise UserError(f"remote {remote.url}: expected results of slider, found none")
    with _no_clean_up(store), ThreadPoolExecutor(CONNECTIONS) as pool:
        arrivals = pool.map(partial(_fetch, store, remote), missing)
        for job, arrival in zip(missing, arrivals, strict=True):
            if isinstance(arrival, DamageError):
                report.add_damaged(job, f"in {remote.url}: {arrival}")
            elif arrival is None:
                report.add("missing in the remote")
            else:
                shared, size = arrival
                report.add(_accept(store, job, shared, remote.url), size)
    return report


def _no_clean_up(store: Store) -> AbstractContextManager[None]:
    return exclusive(store.locks, f"transfer-{uuid.uuid4().hex[:12]}")


def _push(store: Store, remote: Remote, force: bool, job: JobSpec) -> tuple[str, int]:
    """Upload one result; return the outcome and the number of uploaded bytes."""
    manifest = readable(store.manifest_path(job.stage, job.recipe))
    if manifest is None or manifest.input_objects.keys() != job.inputs.keys():
        return "missing here", 0
    if not store.is_intact(manifest.result.object):
        return "damaged", 0
    with suppress(DamageError):
        if not force and (shared := _look_up(remote, job)):
            same = shared[0].result == manifest.result
            return "already in the remote" if same else "different in the remote", 0
    folder = store.object_folder(manifest.result.object)
    lacking = {
        _file(entry): folder / name
        for name, entry in manifest.result.files.items()
        if force or remote.size(_file(entry)) != entry.size
    }
    remote.put(lacking)
    values = plain_manifest(manifest) | {_METADATA: store.metadata(job.stage, job.recipe)}
    remote.write(_result(job), files.canonical(values))
    return "uploaded", sum(path.stat().st_size for path in lacking.values())


def _look_up(remote: Remote, job: JobSpec) -> Shared | None:
    """Manifest and run metadata of a job's result in the remote, or None if it is missing.

    Raises:
        DamageError: the remote has something else under this name.
    """
    content = remote.read(_result(job), _RESULT_SIZE)
    if content is None:
        return None
    try:
        values = json.loads(content)
        metadata = validate_metadata(values.pop(_METADATA))
        manifest = manifest_from(values)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DamageError("expected a manifest, found something else") from None
    names = (manifest.stage, manifest.recipe, manifest.inputs)
    checked = manifest.input_objects.keys() == job.inputs.keys()
    if names != (job.stage, job.recipe, job.input_recipes) or not checked:
        raise DamageError("expected the manifest of this job, found that of another")
    return manifest, metadata


def _fetch(store: Store, remote: Remote, job: JobSpec) -> tuple[Shared, int] | DamageError | None:
    """Download and publish the object of a job's result; also return the downloaded bytes."""
    try:
        shared = _look_up(remote, job)
        if shared is None or store.is_intact(shared[0].result.object):
            return shared and (shared, 0)
        _take(store, remote, shared[0].result)
        return shared, shared[0].result.size
    except DamageError as error:
        return error


def _take(store: Store, remote: Remote, result: Result) -> None:
    """Download and publish an object.

    Raises:
        DamageError: a file is missing, or does not match the manifest.
    """
    with store.temporary("transfer") as folder:
        free = shutil.disk_usage(folder).free
        if result.size > free:
            raise DamageError(f"expected at most {free} bytes, found {result.size}")
        wanted = {folder / name: _file(entry) for name, entry in result.files.items()}
        for path in wanted:
            path.parent.mkdir(parents=True, exist_ok=True)
        if not remote.get(wanted, result.size):
            raise DamageError("expected all files, found fewer")
        if (found := files.digest_table(files.file_table(folder))) != result.object:
            raise DamageError(f"expected object {result.object[:12]}, found {found[:12]}")
        store.publish(folder, result.summary)


def _accept(store: Store, job: JobSpec, shared: Shared, origin: str) -> str:
    """Write manifest, index and run metadata of a result, unless a local job has or computes it."""
    manifest, metadata = shared
    try:
        with exclusive(store.locks, job.recipe, timeout=0):
            if present := store.verify(job.stage, job.recipe):
                same = present.result.object == manifest.result.object
                return "fetched" if same else "computed here"
            if store.find(key := job.key(manifest.input_objects)) is None:
                store.put_index(key, manifest)
            noted = {**metadata, "computed": False, "taken_from": origin}
            files.write_json(store.metadata_path(job.stage, job.recipe), noted)
            inputs = {
                name: [store.verify(item.stage, item.recipe) for item in items]
                for name, items in job.inputs.items()
            }
            objects = {n: [m and m.result.object for m in group] for n, group in inputs.items()}
            if objects != manifest.input_objects:
                return "waiting for inputs"
            store.write_manifest(manifest)
            return "fetched"
    except Timeout:
        return "computed here"


def _result(job: JobSpec) -> str:
    return f"results/{job.recipe}.json"


def _file(entry: FileEntry) -> str:
    return f"files/{entry.sha256}"

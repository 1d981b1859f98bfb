"""Results that travel: push them to a remote, pull those of others into the store.

``results/<recipe>.json`` holds the manifest of a recipe and ``files/<sha256>`` one file of an
object, so that a recipe leads to everything without a listing, which HTTP has not. Whatever arrives
is compared with its digest before the store takes it, and gets its name from the manifest. A result
counts for a recipe only where its inputs are, byte for byte, those that it was computed from;
elsewhere it waits in the index of the store until such inputs are computed.
"""

import json
import shutil
import uuid
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from slider.artefacts.manifest import Manifest, manifest_from, plain_manifest
from slider.artefacts.plan import JobSpec
from slider.artefacts.remote import CONNECTIONS, DamageError, Remote
from slider.artefacts.run_metadata import validate_metadata
from slider.artefacts.store import Store, Timeout, exclusive
from slider.core import files
from slider.core.errors import UserError
from slider.core.files import FileFacts

Jobs = Mapping[str, JobSpec]
"""Jobs by recipe, inputs first."""
Shared = tuple[Manifest, Mapping[str, Any]]
"""A result in a remote: its manifest and the facts beside it."""
_RESULT_SIZE = 16_000_000  # of a manifest, at most [bytes]


@dataclass
class Account:
    """Numbers of results by outcome, bytes that travelled, damage in words."""

    counts: Counter[str] = field(default_factory=Counter)
    size: int = 0
    damage: list[str] = field(default_factory=list)

    def note(self, outcome: str, size: int = 0) -> None:
        """Count one result."""
        self.counts[outcome] += 1
        self.size += size

    def note_damage(self, job: JobSpec, text: str) -> None:
        """Count a damaged result and describe the damage."""
        self.note("damaged")
        self.damage.append(f"{job.label} ({job.recipe[:12]}): damaged {text}")

    def __str__(self) -> str:
        counts = ", ".join(f"{number} {outcome}" for outcome, number in self.counts.items())
        return f"{counts or 'nothing to do'} ({self.size / 1e6:.1f} MB)"


def push(store: Store, jobs: Jobs, remote: Remote, verify: bool = False) -> Account:
    """Send the results of some jobs that are here and not there; replace no whole result.

    With ``verify``, read what is there and replace what is damaged.

    Raises:
        UserError: the remote does not answer or cannot be written.
    """
    remote.open(create=True)
    account = Account()
    with _no_clean_up(store), ThreadPoolExecutor(CONNECTIONS) as pool:
        outcomes = pool.map(partial(_push, store, remote, verify), jobs.values())
        for job, (outcome, size) in zip(jobs.values(), outcomes, strict=True):
            if outcome == "damaged":
                account.note_damage(job, "here: run `slider store verify`")
            else:
                account.note(outcome, size)
    return account


def pull(store: Store, jobs: Jobs, remote: Remote) -> Account:
    """Take the results of some jobs that are there and not here, inputs first.

    Raises:
        UserError: the remote does not answer, or there is no place for what it has.
    """
    account = Account()
    missing = [job for job in jobs.values() if store.whole(job.stage, job.recipe) is None]
    if not missing:
        return account
    if not remote.open():
        raise UserError(f"remote {remote.url}: expected results of slider, found none")
    with _no_clean_up(store), ThreadPoolExecutor(CONNECTIONS) as pool:
        arrivals = pool.map(partial(_fetch, store, remote), missing)
        for job, arrival in zip(missing, arrivals, strict=True):
            if isinstance(arrival, DamageError):
                account.note_damage(job, f"in {remote.url}: {arrival}")
            elif arrival is None:
                account.note("not there")
            else:
                shared, size = arrival
                account.note(_accept(store, job, shared, remote.url), size)
    return account


def _no_clean_up(store: Store) -> AbstractContextManager[None]:
    return exclusive(store.locks, f"travel-{uuid.uuid4().hex[:12]}")


def _push(store: Store, remote: Remote, verify: bool, job: JobSpec) -> tuple[str, int]:
    """Send one result; return the outcome and the bytes that went."""
    manifest = store.present(store.manifest_path(job.stage, job.recipe))
    if manifest is None or manifest.input_objects.keys() != job.inputs.keys():
        return "not here", 0
    if not store.is_whole(manifest.result.object):
        return "damaged", 0
    with suppress(DamageError):
        if shared := _look_up(remote, job):
            if verify:
                with _received(store, shared[0], remote):
                    pass
            same = shared[0].result == manifest.result
            return "already there" if same else "different there", 0
    sent, folder = 0, store.object_folder(manifest.result.object)
    for name, facts in manifest.result.files.items():
        if verify or remote.size(_file(facts)) != facts.size:
            remote.send(folder / name, _file(facts))
            sent += facts.size
    values = plain_manifest(manifest) | {"facts": store.facts(job.stage, job.recipe)}
    remote.write(_result(job), files.canonical(values))
    return "sent", sent


def _look_up(remote: Remote, job: JobSpec) -> Shared | None:
    """Manifest and facts of a job's result in the remote, if it is there.

    Raises:
        DamageError: something else is there.
    """
    content = remote.read(_result(job), _RESULT_SIZE)
    if content is None:
        return None
    try:
        values = json.loads(content)
        facts = validate_metadata(values.pop("facts"))
        manifest = manifest_from(values)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DamageError("expected a manifest, found something else") from None
    names = (manifest.stage, manifest.recipe, manifest.inputs)
    checked = manifest.input_objects.keys() == job.inputs.keys()
    if names != (job.stage, job.recipe, job.input_recipes) or not checked:
        raise DamageError("expected the manifest of this job, found that of another")
    return manifest, facts


@contextmanager
def _received(store: Store, manifest: Manifest, remote: Remote) -> Iterator[Path]:
    """Files of an object in a folder of the store, compared with their digests.

    Raises:
        DamageError: one is missing, or is not what its name says.
    """
    with store.temporary("travel") as folder:
        free = shutil.disk_usage(folder).free
        if manifest.result.size > free:
            raise DamageError(f"expected at most {free} bytes, found {manifest.result.size}")
        for name, facts in manifest.result.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if not remote.fetch(_file(facts), path, facts.size):
                raise DamageError(f"expected {name}, found none")
            if files.digest_file(path) != facts.sha256:
                raise DamageError(f"expected the content of {name}, found another")
        yield folder


def _fetch(store: Store, remote: Remote, job: JobSpec) -> tuple[Shared, int] | DamageError | None:
    """Publish the object of a job's result, if it is there; return also the bytes that came."""
    try:
        shared = _look_up(remote, job)
        if shared is None or store.is_whole(shared[0].result.object):
            return shared and (shared, 0)
        result = shared[0].result
        with _received(store, shared[0], remote) as content:
            store.publish(content, result.summary)
        return shared, result.size
    except DamageError as error:
        return error


def _accept(store: Store, job: JobSpec, shared: Shared, origin: str) -> str:
    """Write what leads to an object, unless a job computes the result or did so meanwhile."""
    manifest, facts = shared
    try:
        with exclusive(store.locks, job.recipe, timeout=0):
            if present := store.whole(job.stage, job.recipe):
                same = present.result.object == manifest.result.object
                return "taken" if same else "computed here"
            if store.indexed(key := job.key(manifest.input_objects)) is None:
                store.remember(key, manifest)
            noted = {**facts, "computed": False, "taken_from": origin}
            files.write_json(store.sidecar_path(job.stage, job.recipe), noted)
            inputs = {
                name: [store.whole(item.stage, item.recipe) for item in items]
                for name, items in job.inputs.items()
            }
            objects = {n: [m and m.result.object for m in group] for n, group in inputs.items()}
            if objects != manifest.input_objects:
                return "of other inputs"
            store.write_manifest(manifest)
            return "taken"
    except Timeout:
        return "computed here"


def _result(job: JobSpec) -> str:
    return f"results/{job.recipe}.json"


def _file(facts: FileFacts) -> str:
    return f"files/{facts.sha256}"

"""A bundle holds what a result came from, and other software can read what it says of it."""

import json
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rocrate import data
from rocrate_validator import models, services
from rocrate_validator.utils.http import HttpRequester

from slider.artefacts.bundle import PROFILE_VERSION, RESULTS
from slider.artefacts.current import current_plan
from slider.artefacts.maintenance import Removed, verify
from slider.artefacts.plan import JobSpec, Plan, build_plan, write_plan
from slider.artefacts.recipe import Code, code_of
from slider.artefacts.store import Store
from slider.cli import main
from slider.core import files
from tests.artefacts.samples import DATA, compute, damage

CODE = code_of("slider.library.stage:run")
GAITS = [JobSpec("gait", "gait", CODE, {"value": value}) for value in (1, 2)]
POLICY = JobSpec("walking", "training", CODE, {}, {"library": GAITS})
TABLE = JobSpec("table1", "Table 1", CODE, {}, {"policy": [POLICY]})
OTHERS = JobSpec("stability", "stability", CODE, {}, {"gaits": GAITS})
PLAN = build_plan({"table1": TABLE, "walking": POLICY})
OVERRIDES = "train.seed=2 gait.cost=torque"
START, MIDDLE, END = (f"2026-01-01T00:0{minute}:00.000+00:00" for minute in range(3))


@pytest.fixture
def project(tmp_path, monkeypatch) -> Path:
    """A working copy with a store; the two gaits have the same content."""
    root = tmp_path / "a project"
    (root / "pipeline" / "profiles").mkdir(parents=True)
    (root / "pipeline" / "profiles" / "config.yaml").write_text("jobs: 1\n")
    (root / "profiles").symlink_to("pipeline/profiles")
    (root / "Snakefile").write_text("rule all:\n    input: []\n")
    (root / "CITATION.cff").write_text(
        "title: A title\nabstract: Text.\nversion: 0.1.0\nauthors:\n"
        "  - {given-names: Ada, family-names: Example}\n  - name: A group\n"
    )
    for command in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", "-C", root, *command], check=True)
    (root / "untracked.txt").write_text("private")
    lay_out(Store(root / "artefacts"), PLAN)
    monkeypatch.chdir(root)
    return root


def lay_out(store: Store, plan: Plan) -> None:
    for spec in plan.jobs.values():
        facts = {"started": START if spec is GAITS[0] else MIDDLE, "overrides": OVERRIDES}
        facts["ended"] = END if spec is TABLE else MIDDLE
        compute(store, spec, facts=facts, table1="a,b\n")
    write_plan(plan, store.root / "plans")


def unpacked(project: Path) -> Path:
    folder = project.parent / "elsewhere"
    with zipfile.ZipFile(project / "reports" / "table1.crate.zip") as archive:
        archive.extractall(folder)
    return folder


def entities(folder: Path) -> dict[str, Any]:
    graph = json.loads((folder / "ro-crate-metadata.json").read_text())["@graph"]
    return {entity["@id"]: entity for entity in graph}


def test_the_archive_has_every_file_the_actions_and_a_whole_store(project, capsys):
    assert main(["bundle", "table1"]) == 0
    line = f"snakemake -j2 reports/table1.csv --config hydra='{OVERRIDES}'"
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == f"unpacked, this has the results: {line}"
    assert printed.err == ""
    folder = unpacked(project)
    graph = entities(folder)

    listed = {name for name, entity in graph.items() if "sha256" in entity}
    unlisted = {"ro-crate-metadata.json", "Snakefile"}
    present = {name for name in files.list_files(folder) if not name.endswith(".json")}
    assert present - unlisted <= listed
    for name in listed:
        assert files.digest_file(folder / name) == graph[name]["sha256"]
        assert (folder / name).stat().st_size == graph[name]["contentSize"]
    assert not (folder / "untracked.txt").exists()
    assert (folder / "profiles" / "config.yaml").read_text() == "jobs: 1\n"
    assert (folder / RESULTS / "table1" / "table1.csv").read_text() == "a,b\n"

    run, table = graph["#run"], graph[f"#{TABLE.recipe}"]
    assert (run["startTime"], run["endTime"]) == (START, END)
    assert line in run["description"]
    assert {"@id": "#overrides"} in run["object"]
    assert graph["#overrides"]["value"] == OVERRIDES
    assert {"@id": f"{RESULTS}/table1/table1.csv"} in run["result"]
    assert table["object"] == [graph[f"#{POLICY.recipe}"]["result"]]
    assert graph[f"#{GAITS[0].recipe}"]["result"] == graph[f"#{GAITS[1].recipe}"]["result"]
    versions = {e["name"]: e["softwareVersion"] for e in graph.values() if "softwareVersion" in e}
    assert CODE.versions.items() <= versions.items()
    store = Store(folder / "artefacts")
    assert verify(store) == Removed([], [])
    plan = current_plan(store)
    assert all(job.code.parts for job in plan.jobs.values())


@pytest.mark.parametrize("names", [["table1", "ablation"], ["ablation", "table1"], ["ablation"]])
def test_the_policy_is_that_of_the_table_or_of_the_first_target(project, names):
    variant = replace(POLICY, label="a variant", section={"seed": 2})
    first = POLICY if "table1" in names else variant
    ablation = replace(TABLE, stage="ablation", inputs={"policy": [variant, POLICY]})
    lay_out(Store(project / "artefacts"), build_plan({"table1": TABLE, "ablation": ablation}))
    assert main(["bundle", *names, "--out", "reports/table1.crate.zip"]) == 0
    found = entities(unpacked(project))
    title = found[f"#{first.recipe}"]["name"]
    assert (unpacked(project) / RESULTS / "policy" / DATA).read_text() == f"{title} "


def get(_, url: str, **__) -> SimpleNamespace:
    """What a request for a context gets, without a network."""
    if url == "https://w3id.org/ro/terms/workflow-run/context":
        terms = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}
    else:
        assert url == "https://w3id.org/ro/crate/1.1/context"
        terms = json.loads((Path(data.__path__[0]) / "ro-crate.jsonld").read_text())["@context"]
        # The library has those of RO-Crate 1.3, where these places changed.
        changed = ("ComputationalWorkflow", "FormalParameter")
        terms |= {name: f"https://bioschemas.org/{name}" for name in changed}
    values, headers = {"@context": terms}, {"Content-Type": "application/ld+json"}
    facts = {"json": lambda: values, "text": json.dumps(values), "raise_for_status": lambda: None}
    return SimpleNamespace(status_code=200, ok=True, headers=headers, **facts)


def test_the_validator_of_the_profile_finds_nothing_required_missing(project, monkeypatch):
    monkeypatch.setattr(HttpRequester, "get", get, raising=False)
    assert main(["bundle", "table1"]) == 0
    folder = unpacked(project)
    assert issues(folder) == []
    path = folder / "ro-crate-metadata.json"
    path.write_text(path.read_text().replace('"license"', '"licence"'))
    assert any("license" in issue for issue in issues(folder))


def issues(folder: Path) -> list[str]:
    settings = services.ValidationSettings(
        rocrate_uri=str(folder),
        profile_identifier=f"workflow-run-crate-{PROFILE_VERSION}",
        requirement_severity=models.Severity.REQUIRED,
    )
    return [str(issue.message) for issue in services.validate(settings).get_issues()]


def test_a_damaged_result_is_not_packed(project, refused):
    store = Store(project / "artefacts")
    damage(store.object_folder(store.read_manifest("gait", GAITS[0].recipe).result.object) / DATA)
    assert "expected the gait result" in refused("bundle", "table1")
    assert not [*Path().glob("reports/*")]


def test_what_cannot_be_packed_is_one_line(project, refused):
    assert "found table2" in refused("bundle", "table2")
    plan = build_plan({**{n: PLAN.jobs[r] for n, r in PLAN.targets.items()}, "stability": OTHERS})
    write_plan(plan, project / "artefacts" / "plans")
    assert "`snakemake -j2 publish_stability`" in refused("bundle", "stability")
    Store(project / "artefacts").manifest_path("gait", GAITS[0].recipe).unlink()
    assert "expected a manifest, found none" in refused("bundle", "table1")


def test_a_plan_of_other_source_is_refused(project, refused):
    code = Code(CODE.entry, "0" * 64, CODE.versions)
    plan = build_plan({"table1": JobSpec("table1", "Table 1", code, {})})
    lay_out(Store(project / "artefacts"), plan)
    expected = "expected the source with which slider.library.stage:run ran"
    assert expected in refused("bundle", "table1")

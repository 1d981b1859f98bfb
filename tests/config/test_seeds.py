"""What is reported and what is chosen by draw from different seeds."""

import pytest

from pipeline.stages import table1_jobs
from pipeline.stages.evaluation import protocol_jobs
from slider.artefacts.plan import JobSpec
from tests.config.composed import composed
from tests.pipeline.test_studies import study

pytestmark = pytest.mark.usefixtures("constant_code")
FINETUNED = "finetuning=robust"


def drawn(reports: list[JobSpec]) -> set[int]:
    """Seeds that the evaluations of reports draw from."""
    found: set[int] = set()
    for job in (job for report in reports for job in report.inputs["evaluations"]):
        protocol = job.section["evaluation"]
        found |= set(range(protocol["seed"], protocol["seed"] + protocol["trials"]))
    return found


@pytest.mark.parametrize("experiment", ["default", "paper"])
def test_no_reported_seed_is_chosen_by(experiment):
    """Of the others the validation knows the blocks, as below."""
    given = f"experiment={experiment}"
    config = composed(given)
    jobs = table1_jobs(config)
    protocols = protocol_jobs(config, jobs)
    seeds = study("seeds", experiment=given)
    final = drawn([jobs["table1"], *protocols.values(), seeds])

    chosen_by, run = "evaluation=development", "study.ablation.run=[default,without_pretraining]"
    compared = study("ablation", chosen_by, run, experiment=given)
    tuned = composed(given, chosen_by, FINETUNED)
    chosen = drawn([compared, table1_jobs(tuned)["table1"]])
    chosen |= {training.selection.seed for training in tuned.trainings.values()}

    assert len(final) >= 2
    assert len(chosen) >= 2
    assert not final & chosen
    assert final <= set(range(config.seeds.final.first, config.seeds.final.last + 1))


def test_one_value_moves_a_block():
    moved = composed("seeds.final={first: 50000, last: 50099}")
    assert {moved.evaluation.seed, *(p.seed for p in moved.protocols.values())} == {50000}
    config = composed("seeds.final.first=20300")
    for name in ("seeds", "sensitivity"):
        assert config.study[name].evaluation.seed == 20300

"""Reports of the protocols beside that of Table 1 (``config.protocols``)."""

from collections.abc import Mapping

from pipeline.stages.entries import job
from pipeline.stages.evaluation import evaluations_of, labels, protocol_section
from slider.artefacts.plan import JobSpec
from slider.config.schema import Config


def protocol_jobs(config: Config, made: Mapping[str, JobSpec]) -> dict[str, JobSpec]:
    """The report of each further protocol; nothing on the way to Table 1 needs them."""
    return {name: protocol_report(config, name, made) for name in config.protocols}


def protocol_report(config: Config, name: str, made: Mapping[str, JobSpec]) -> JobSpec:
    """Table and figure of a protocol: of constant speeds, of segments of a case, or of cases."""
    protocol = config.protocols[name]
    stage = "speeds" if protocol.profile is None else protocol.profile.rows
    section = {
        "name": name,
        "evaluation": protocol_section(protocol),
        "labels": labels(config, protocol.controllers),
    }
    return job(stage, name, section, {"evaluations": evaluations_of(config, protocol, made)})

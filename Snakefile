# From the configuration to Table 1. The jobs come from pipeline/stages/; see README.md.
#   snakemake -j2 reports/table1.csv --config hydra='experiment=smoke'
import os
import sys
from pathlib import Path

# The source beside this file, whatever is installed; as for the jobs, no PYTHONPATH. Of this
# folder only one package: a yaml.py is not what the installed ones mean.
FOREIGN = {
    workflow.basedir,
    *map(os.path.abspath, filter(None, os.environ.get("PYTHONPATH", "").split(":"))),
}
sys.path[:] = [workflow.basedir, *(path for path in sys.path if path not in FOREIGN)]
import pipeline

sys.path[0] = f"{workflow.basedir}/src"
from pipeline.console import Console
from pipeline.entry import end_as_by_ctrl_c, open_pipeline


report: "pipeline/captions/workflow.rst"


end_as_by_ctrl_c()
CONSOLE = Console(workflow)
PIPELINE = open_pipeline(
    config,
    Path(workflow.basedir) / "conf",
    cores=workflow.resource_settings.cores or 1,
    dry_run=workflow.output_settings.dryrun,
)


wildcard_constraints:
    recipe="[0-9a-f]{64}",


# Here, since Snakemake forgets a default target that an included file sets.
rule all:
    """Table 1."""
    default_target: True
    input:
        PIPELINE.reports["table1"],


include: "pipeline/rules/stages.smk"
include: "pipeline/rules/reports.smk"


onstart:
    PIPELINE.start(workflow)
    CONSOLE.open(PIPELINE.plan, PIPELINE.store, PIPELINE.tracking)


onsuccess:
    PIPELINE.finish(succeeded=True)
    CONSOLE.close()


onerror:
    PIPELINE.finish(succeeded=False)
    CONSOLE.close()

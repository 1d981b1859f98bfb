# One rule per stage; its jobs differ in their recipe alone.
from pipeline.stages.entries import ENTRIES

TRAININGS = ("standing", "walking")


for stage in ENTRIES:

    rule:
        name:
            "draw_figures" if stage == "figures" else stage  # `figures` is a target
        input:
            PIPELINE.inputs,
        output:
            f"artefacts/{stage}/{{recipe}}.json",
        log:
            f"artefacts/logs/{stage}/{{recipe}}.log",
        # Nothing but the table waits for the baseline: it fills what the way to the policy leaves.
        priority: -1 if stage == "baseline" else 0
        # A training has the machine to itself.
        threads: PIPELINE.config.resources.threads if stage in TRAININGS else 1
        shell:
            "{PIPELINE.run} {wildcards.recipe} --threads {threads}"


rule gait_library:
    """All gaits in one Zarr store."""
    input:
        PIPELINE.manifest("library"),

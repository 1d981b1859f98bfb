# One rule per stage; its jobs differ in their recipe alone.
from pipeline.stages.entries import STAGES

TRAININGS = ("standing", "walking")
# Among ready jobs Snakemake starts those of the highest priority. The way to the policy comes first,
# then what the controller HZD waits for. All else fills the slots that these leave.
PRIORITIES = dict.fromkeys(
    ("gait", "library", *TRAININGS, "evaluation", "table1"), 2
) | dict.fromkeys(("stability_gaits", "foot_placement"), 1)


for stage in STAGES:

    rule:
        name:
            "draw_figures" if stage == "figures" else stage  # `figures` is a target
        input:
            PIPELINE.inputs,
        output:
            f"artefacts/{stage}/{{recipe}}.json",
        log:
            f"artefacts/logs/{stage}/{{recipe}}.log",
        priority: PRIORITIES.get(stage, 0)
        # A job of several cores waits until as many are free at once.
        threads: PIPELINE.config.resources.threads or 1 if stage in TRAININGS else 1
        resources:
            pool=(
                (lambda wildcards, threads: PIPELINE.threads(threads))
                if stage in TRAININGS
                else 1
            ),
            gpu=PIPELINE.gpu if stage in TRAININGS else 0,
        shell:
            "{PIPELINE.run} {wildcards.recipe} --threads {resources.pool}"


rule gait_library:
    """All gaits in one Zarr store."""
    input:
        PIPELINE.manifest("library"),

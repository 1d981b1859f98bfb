# Reports that people read: copies out of the store.
CAPTIONS = Path(workflow.basedir) / "pipeline" / "captions"


def captioned(name):
    """A file that `snakemake --report` shows, if it has a caption."""
    caption = CAPTIONS / f"{Path(name).stem}.rst"
    if not caption.is_file():
        return name
    labels = {"file": Path(name).name}
    return report(name, caption=caption, category="Results", labels=labels)


for target, names in PIPELINE.reports.items():

    rule:
        name:
            f"publish_{target}"
        input:
            manifest=PIPELINE.manifest(target),
            # Which result is the current one, also when its manifest is older than the reports.
            marker=f"artefacts/current/{target}",
        output:
            [captioned(name) for name in names],
        localrule: True
        shell:
            "{PIPELINE.slider} publish {input.manifest:q} {output:q}"


rule policy:
    """The walking policy, with all that its use elsewhere takes."""
    input:
        PIPELINE.reports["policy_export"],


rule figures:
    """Pictures of the gait library."""
    input:
        PIPELINE.reports["figures"],

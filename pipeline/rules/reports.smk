# Reports that people read: copies out of the store.


def captioned(name):
    """A file that `snakemake --report` shows, with its caption."""
    caption = f"../captions/{Path(name).stem}.rst"
    return report(
        name, caption=caption, category="Results", labels={"file": Path(name).name}
    )


rule publish_table1:
    input:
        manifest=PIPELINE.manifest("table1"),
        # Which table is the current one, also when its manifest is older than the reports.
        marker="artefacts/current/table1",
    output:
        [captioned(name) for name in REPORTS["table1"]],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"


rule report:
    input:
        manifest=PIPELINE.manifest("report"),
        marker="artefacts/current/report",
    output:
        [captioned(name) for name in REPORTS["report"]],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"


rule build_report:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/report/{recipe}.json",
    log:
        "artefacts/logs/report/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule video:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/video/{recipe}.json",
    log:
        "artefacts/logs/video/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"

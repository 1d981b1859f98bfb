# Which guesses carry the result, beside the way to Table 1:
#   snakemake -j2 reports/sensitivity.csv


rule sensitivity_policy:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/sensitivity_policy/{recipe}.json",
    log:
        "artefacts/logs/sensitivity_policy/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule sensitivity:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/sensitivity/{recipe}.json",
    log:
        "artefacts/logs/sensitivity/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule publish_sensitivity:
    input:
        # A function: only who asks for it waits until the changed robots are laid out.
        manifest=PIPELINE.sensitivity_manifest,
        marker="artefacts/current/sensitivity",
    output:
        [captioned(name) for name in REPORTS["sensitivity"]],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"

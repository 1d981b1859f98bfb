# Protocols beside that of Table 1, each with a table and a figure:
#   snakemake -j2 reports/sweep.csv reports/joystick.csv reports/heldout.csv


rule speeds:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/speeds/{recipe}.json",
    log:
        "artefacts/logs/speeds/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule segments:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/segments/{recipe}.json",
    log:
        "artefacts/logs/segments/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule cases:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/cases/{recipe}.json",
    log:
        "artefacts/logs/cases/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


for protocol in PIPELINE.config.protocols:

    rule:
        name:
            f"publish_{protocol}"
        input:
            manifest=PIPELINE.manifest(protocol),
            marker=f"artefacts/current/{protocol}",
        output:
            [captioned(name) for name in protocol_files(protocol)],
        shell:
            "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"

# Independent checks of the gaits, beside the way to Table 1:
#   snakemake -j2 reports/verification.csv


rule verification_gaits:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/verification_gaits/{recipe}.json",
    log:
        "artefacts/logs/verification_gaits/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule verification:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/verification/{recipe}.json",
    log:
        "artefacts/logs/verification/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule publish_verification:
    input:
        manifest=PIPELINE.manifest("verification"),
        marker="artefacts/current/verification",
    output:
        REPORTS["verification"],
    shell:
        "{sys.executable} -m slider.cli publish {input.manifest} {output}"

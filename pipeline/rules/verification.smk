# Independent checks of the gaits, beside the way to Table 1:
#   snakemake -j2 reports/verification.csv reports/figures/verification_maps.svg


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
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"


rule verification_maps:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/verification_maps/{recipe}.json",
    log:
        "artefacts/logs/verification_maps/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule publish_verification_maps:
    input:
        manifest=PIPELINE.manifest("verification_maps"),
        marker="artefacts/current/verification_maps",
    output:
        REPORTS["verification_maps"],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"

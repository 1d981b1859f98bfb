# What each choice of the method is worth, beside the way to Table 1:
#   snakemake -j2 reports/ablation.csv reports/seeds.csv


rule ablation:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/ablation/{recipe}.json",
    log:
        "artefacts/logs/ablation/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule publish_ablation:
    input:
        # A function: only who asks for the ablation waits until its variants are laid out.
        manifest=PIPELINE.ablation_manifest,
        marker="artefacts/current/ablation",
    output:
        REPORTS["ablation"],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"


rule publish_seeds:
    input:
        manifest=PIPELINE.seeds_manifest,
        marker="artefacts/current/seeds",
    output:
        REPORTS["seeds"],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"

# Pictures of the gait library, beside the way to Table 1:
#   snakemake -j2 figures
SOLVE_TIMES = "reports/figures/solve_times"


rule draw_figures:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/figures/{recipe}.json",
    log:
        "artefacts/logs/figures/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule publish_figures:
    input:
        manifest=PIPELINE.manifest("figures"),
        marker="artefacts/current/figures",
    output:
        REPORTS["figures"],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"


# Times are a measurement and no result: they are drawn from what is noted beside the gaits.
rule solve_times:
    input:
        PIPELINE.manifest("library"),
    output:
        multiext(SOLVE_TIMES, ".svg", ".png", ".md"),
    shell:
        "{sys.executable:q} -m slider.cli library times --out {SOLVE_TIMES}"


rule figures:
    input:
        REPORTS["figures"],
        rules.solve_times.output,

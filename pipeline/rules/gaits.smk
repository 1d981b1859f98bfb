# The functions that all gaits share, one eHZD gait per commanded velocity, and the library.


rule problem:
    output:
        "artefacts/problem/{recipe}.json",
    log:
        "artefacts/logs/problem/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule gait:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/gait/{recipe}.json",
    log:
        "artefacts/logs/gait/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule library:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/library/{recipe}.json",
    log:
        "artefacts/logs/library/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule gait_library:
    input:
        PIPELINE.manifest("library"),

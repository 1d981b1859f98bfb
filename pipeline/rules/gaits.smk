# One eHZD gait per commanded velocity, and the library.


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

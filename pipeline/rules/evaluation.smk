# The ten-trial protocol, one job per controller and command.


rule evaluation:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/evaluation/{recipe}.json",
    log:
        "artefacts/logs/evaluation/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule baseline:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/baseline/{recipe}.json",
    log:
        "artefacts/logs/baseline/{recipe}.log",
    # Nothing but the table waits for it: fill what the way to the policy leaves.
    priority: -1
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


rule table1:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/table1/{recipe}.json",
    log:
        "artefacts/logs/table1/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"

# Standing pre-training, then guided walking. A training has the machine to itself.


rule standing:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/standing/{recipe}.json",
    log:
        "artefacts/logs/standing/{recipe}.log",
    threads: PIPELINE.config.resources.threads
    shell:
        "{PIPELINE.run} {wildcards.recipe} --threads {threads}"


rule walking:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/walking/{recipe}.json",
    log:
        "artefacts/logs/walking/{recipe}.log",
    threads: PIPELINE.config.resources.threads
    shell:
        "{PIPELINE.run} {wildcards.recipe} --threads {threads}"


rule policy:
    input:
        PIPELINE.manifest("walking"),

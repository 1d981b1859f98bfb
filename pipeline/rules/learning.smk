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


rule export_policy:
    input:
        PIPELINE.inputs,
    output:
        "artefacts/policy_export/{recipe}.json",
    log:
        "artefacts/logs/policy_export/{recipe}.log",
    shell:
        "{PIPELINE.run} {wildcards.recipe}"


# The walking policy, with all that its use elsewhere takes.
rule policy:
    input:
        manifest=PIPELINE.manifest("policy_export"),
        marker="artefacts/current/policy_export",
    output:
        REPORTS["policy_export"],
    shell:
        "{sys.executable:q} -m slider.cli publish {input.manifest} {output}"

# Reports that people read: copies out of the store.


rule publish_table1:
    default_target: True
    input:
        manifest=PIPELINE.manifest("table1"),
        # Which table is the current one, also when its manifest is older than the report.
        marker="artefacts/current/table1",
    output:
        "reports/table1.csv",
    shell:
        "{sys.executable} -m slider.cli publish {input.manifest} {output}"

# Reports that people read: copies out of the store.


rule publish_table1:
    input:
        manifest=PIPELINE.manifest("table1"),
        # Which table is the current one, also when its manifest is older than the reports.
        marker="artefacts/current/table1",
    output:
        TABLE1_REPORTS,
    shell:
        "{sys.executable} -m slider.cli publish {input.manifest} {output}"

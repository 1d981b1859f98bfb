# make table1                            Table 1 of our controller
# make table1 HYDRA="experiment=smoke"   with overrides of the configuration
# make report                           one page about everything, with videos
# make results                          fill the result tables of README.md and docs/ from reports/
# make animation                         the picture at the top of README.md, from the trained policy
# make docs                             the documentation as a site
# make test                              lint, type check and tests
# make faults                            kill jobs, fill the disk and damage the store, in every way
PYTHON ?= python3
CORES ?= $(shell nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)
HYDRA ?=
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/installed

.DELETE_ON_ERROR:
.PHONY: table1 report results animation docs install lint test faults clean

table1: $(STAMP)
	PATH="$(abspath $(BIN)):$$PATH" snakemake -j$(CORES) reports/table1.csv --config hydra='$(HYDRA)'

report: $(STAMP)
	PATH="$(abspath $(BIN)):$$PATH" snakemake -j$(CORES) reports/index.html --config hydra='$(HYDRA)'

results: $(STAMP) # tables of README.md and docs/, from the finished runs in reports/
	$(BIN)/slider results

animation: $(STAMP)
	$(BIN)/slider play --film docs/images/walk.webp --command 1.2 0 0

docs: $(STAMP) # site/; a broken link is an error
	$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[docs]'
	$(BIN)/mkdocs build --strict

install: $(STAMP)

$(STAMP): pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[test]'
	touch $@

lint: $(STAMP)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/snakefmt --check Snakefile pipeline
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/pyright

test: lint # each process takes whole files, in the order of tests/conftest.py
	$(BIN)/python -m pytest -n $(CORES) --dist loadfile --no-loadscope-reorder

faults: $(STAMP) # kills, full disks and damage, some minutes
	$(BIN)/python -m pytest -m faults -s tests/faults

clean: # what is left of interrupted jobs and of forgotten configurations
	$(BIN)/slider store gc

# make table1                            Table 1 of our controller
# make table1 HYDRA="experiment=smoke"   with overrides of the configuration
# make demo                              the robot walks, in a window or the browser
# make demo POLICY=docs/policy-outdoor   a policy for slopes and stairs
# make report                           one page about everything, with videos
# make results                          fill the result tables of README.md and docs/ from reports/
# make policy                            train, evaluate and ship docs/policy, or POLICY
# make animation                         the film at the top of README.md, of docs/policy
# make docs                             the documentation as a site
# make install                           what tests, checks of gaits and editors need, too
# make test                              lint, type check and tests
# make faults                            kill jobs, fill the disk and damage the store, in every way
PYTHON ?= python3
# Known once the environment is there, as recipes are.
CORES ?= $(shell $(VENV)/bin/python -I -c 'from slider.core.machine import cores; print(cores())')
HYDRA ?=
POLICY ?= docs/policy
VENV := .venv
# A module: the first line of a script cannot name every folder. Isolated from PYTHON* and from files here.
RUN := $(VENV)/bin/python -I -m
PLACE := $(VENV)/place# the folder in which the environment works
STAMP := $(VENV)/installed
TOOLS := $(VENV)/installed-tools
export HYDRA
export PLACED := $(CURDIR)
# pip installs into $(VENV), whatever it does elsewhere on this machine.
export PIP_USER := 0
unexport PIP_TARGET PIP_PREFIX PIP_ROOT
# An environment that was copied, moved or broken is made anew: it would run the source of another
# folder, or none.
ifneq ($(shell $(VENV)/bin/python -I -X utf8 -c 'print(open("$(PLACE)", encoding="utf-8").read())' 2>/dev/null),$(CURDIR))
.PHONY: $(PLACE)
endif

.DELETE_ON_ERROR:
.PHONY: table1 demo report results policy animation docs install lint test faults clean

table1: $(STAMP)
	$(RUN) snakemake -j$(CORES) reports/table1.csv --config "hydra=$$HYDRA"

demo: $(STAMP)
	$(RUN) slider.cli play --policy $(POLICY) --set robot=slider

report: $(STAMP)
	$(RUN) snakemake -j$(CORES) reports/index.html --config "hydra=$$HYDRA"

results: $(STAMP) # tables of README.md and docs/, from the finished runs in reports/
	$(RUN) slider.cli results

SHIPPED := policy.onnx estimator.onnx policy.json robot.xml
policy: $(STAMP)
	test -f $(POLICY)/README.md
	$(RUN) snakemake -j$(CORES) policy reports/table1.csv --config "hydra=$$HYDRA"
	$(RUN) slider.cli results $(POLICY)/README.md
	cp $(SHIPPED:%=reports/policy/%) $(POLICY)

animation: $(STAMP)
	$(RUN) slider.cli play --policy docs/policy --set robot=slider --tiles --film $(VENV)/walk.webp
	mv $(VENV)/walk.webp docs/images/walk.webp

docs: $(STAMP) # site/; a broken link is an error
	$(RUN) pip install --quiet -c constraints.txt -e '.[docs]'
	$(RUN) mkdocs build --strict

install: $(TOOLS)

$(PLACE):
	@$(PYTHON) -I -c 'import sys; v = sys.version.split()[0]; (3, 11) <= sys.version_info < (3, 14) or sys.exit("expected Python 3.11 to 3.13, found " + v + ": make PYTHON=/path/to/python")'
	@if [ -L $(VENV) ] || [ -e $(VENV) -a ! -e $(PLACE) ]; then echo "expected no $(VENV) or one that make made, found another: move it away, or make VENV=another-name" >&2; exit 1; fi
	rm -rf $(VENV)
	mkdir $(VENV)
	@: > $@ # ours, whenever it is interrupted
	$(PYTHON) -I -m venv $(VENV)
	@printf '%s' "$$PLACED" > $@

$(STAMP): pyproject.toml constraints.txt $(PLACE)
	$(RUN) pip install --quiet -c constraints.txt -e .
	touch $@

$(TOOLS): $(STAMP)
	$(RUN) pip install --quiet -c constraints.txt -e '.[test]'
	touch $@

lint: $(TOOLS)
	$(RUN) ruff check
	$(RUN) ruff format --check
	$(RUN) snakefmt --check Snakefile pipeline
	$(RUN) pyright

test: lint # each process takes whole files, in the order of tests/conftest.py
	$(RUN) pytest -n $(CORES) --dist loadfile --no-loadscope-reorder

faults: $(TOOLS) # kills, full disks and damage, some minutes
	$(RUN) pytest -m faults -s tests/faults

clean: # what is left of interrupted jobs and of forgotten configurations
	$(RUN) slider.cli store gc

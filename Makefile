# Set-up, reproduction and checks; `make` alone lists the targets.

PYTHON ?= python3
CORES ?= 2

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
# Python compiles what it imports; compiling all of it first takes a third of the set-up. It must keep it, though: a
# shell that tells it not to would have each job compile its libraries anew, 2 to 3 s.
LOCK_OPTIONS := --no-deps --no-compile --require-hashes
unexport PYTHONDONTWRITEBYTECODE
# Jobs of the workflow find the environment's programs first.
SNAKEMAKE = PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/snakemake

# A stamp in the environment is named after what it was made from, so that a change of that makes it anew.
stamp = $(VENV)/$(1)-$(shell { $(PYTHON) -V; cat $(2); } 2>&1 | cksum | tr ' ' -)
LOCKED := $(call stamp,locked,requirements-cpu.lock requirements.lock)
INSTALLED := $(call stamp,installed,pyproject.toml)
TESTABLE := $(call stamp,testable,requirements-test.lock)

.PHONY: help reproduce quick check lint test smoke golden rtl pages site setup setup-test lock clean check-python

help:
	@echo "make reproduce  set up $(VENV) and run the full workflow (results/, paper_figures/)"
	@echo "make quick      the same from the networks that come with the project (results/quick/, paper_figures/quick/)"
	@echo "make test       set up $(VENV) with the test tools and run every check but those of the board in logic"
	@echo "make check      linters, types and the quick tests, before a commit"
	@echo "make smoke      run the same workflow with tiny budgets (results/smoke/, paper_figures/smoke/)"
	@echo "make golden     run it from stored networks with small counts and compare its numbers with tests/golden"
	@echo "make rtl        test the board in logic: arithmetic, blocks, recordings, proofs"
	@echo "make pages      write again what pages show of code, settings and kept results"
	@echo "make site       build the pages as a site (build/site)"
	@echo "make setup      set up $(VENV) alone; make setup-test with the test tools"
	@echo "make lock       make the requirements*.lock files again from pyproject.toml, but for -cpu and -uv"
	@echo "make clean      remove $(VENV) and caches; results stay"
	@echo "Variables: PYTHON=$(PYTHON) CORES=$(CORES)"

reproduce: setup
	$(SNAKEMAKE) --cores $(CORES)

quick: setup
	$(SNAKEMAKE) --cores $(CORES) --configfile config/quick.yaml

smoke: setup
	$(SNAKEMAKE) --cores $(CORES) --configfile config/smoke.yaml

# In float32, which every processor has.
# The study first: the report shows what is there when it is made.
GOLDEN = ONEDNN_MAX_CPU_ISA=AVX2 ATEN_CPU_CAPABILITY=avx2 \
  $(SNAKEMAKE) --cores $(CORES) --configfile config/golden.yaml --
golden: setup
	$(GOLDEN) study
	$(GOLDEN) all
	$(BIN)/python .ci/golden.py

rtl: setup-test
	@$(PIP) install --quiet $(LOCK_OPTIONS) -r requirements-rtl.lock
	$(BIN)/python -m pytest -n $(CORES) --dist loadfile rtl/tests tests/board/test_logic.py

pages: setup
	$(BIN)/python config/reference.py
	$(BIN)/python docs/refresh.py --ledger

# Its packages are no part of the project, so they have an environment of their own.
site: | check-python
	@[ -x build/site-venv/bin/mkdocs ] || { $(PYTHON) -m venv build/site-venv && \
	  build/site-venv/bin/python -m pip --disable-pip-version-check install --quiet $(LOCK_OPTIONS) -r requirements-site.lock; }
	build/site-venv/bin/python docs/build_site.py

# Folders of tests that take long together are left to `make test`.
check: lint
	$(BIN)/python -m pytest -n $(CORES) --dist loadfile -m "not slow" $(foreach part,studies report project,--ignore tests/$(part))

test: lint
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python -m pytest -n $(CORES) --dist loadfile

lint: setup-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/snakefmt --check Snakefile workflow
	$(SNAKEMAKE) --lint

setup: $(INSTALLED)

setup-test: $(TESTABLE)

$(LOCKED): | check-python
	@echo "Setting up $(VENV)"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python envs/install.py
	@touch $@

$(INSTALLED): $(LOCKED)
	@$(PIP) install --quiet --no-deps --no-build-isolation --editable .
	@rm -f $(VENV)/installed-*
	@touch $@

$(TESTABLE): $(INSTALLED)
	@$(PIP) install --quiet $(LOCK_OPTIONS) -r requirements-test.lock
	@rm -f $(VENV)/testable-*
	@touch $@

lock: | check-python
	$(PYTHON) -m venv build/lock-venv
	build/lock-venv/bin/python -m pip --disable-pip-version-check install --quiet $(LOCK_OPTIONS) -r requirements-uv.lock
	build/lock-venv/bin/python envs/lock.py

check-python:
	@$(PYTHON) -c "import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))" 2>/dev/null || { \
	  echo "error: PYTHON: found $(PYTHON) ($$($(PYTHON) -V 2>&1 | head -n 1)), expected Python 3.11 to 3.13," \
	    "for example make reproduce PYTHON=python3.11" >&2; exit 1; }
	@$(PYTHON) -c "import ensurepip, venv" 2>/dev/null || { \
	  echo "error: PYTHON: found $(PYTHON) without the venv module, expected one with it;" \
	    "on Debian or Ubuntu: apt-get install python3-venv" >&2; exit 1; }
	@$(PYTHON) -c "import os, shlex; assert shlex.split(os.getcwd()) == [os.getcwd()]" 2>/dev/null || { \
	  echo "error: folder: found $$PWD, expected a path without blanks and quotes," \
	    "which Snakemake does not pass to its jobs" >&2; exit 1; }

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis build src/*.egg-info
	find src tests workflow envs benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

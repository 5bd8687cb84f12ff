# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

# `make demo` and `make test` need Python 3.10 to 3.13, make and a C/C++
# compiler; everything else comes from PyPI into .venv.

PYTHON ?= python3
MINUTES ?= 3
SEED ?= 1
VENV := .venv
BIN := $(VENV)/bin
PIP_INSTALL := $(BIN)/python .ci/pip_install.py
SITE ?= build/site
SOURCES := $(shell find colcon_yamllaunch -name '*.py' -o -name '*.em' \
	-o -name '*.css' -o -name py.typed) \
	$(shell find sample_ws/flow sample_ws/src sample_ws/talk -type f \
	! -path '*/__pycache__/*')
COLCON_PRODUCTS := $(addprefix sample_ws/,build install log)

# What a sourced ROS installation leaves in the shell must not mix with the
# ROS 2 wheels, and colcon's make must not think that it is a part of this one.
ifdef AMENT_PREFIX_PATH
unexport LD_LIBRARY_PATH
endif
unexport AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONPATH
unexport RMW_IMPLEMENTATION ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE
unexport MAKEFLAGS MAKELEVEL MFLAGS
export PATH := $(CURDIR)/$(BIN):$(PATH)

.NOTPARALLEL:
.PHONY: help demo test quick gate lint coverage docs hostile fuzz soak
.PHONY: clean distclean

help:
	@echo 'make demo       build and launch sample_ws, stop after 15 seconds'
	@echo 'make test       make lint and all tests'
	@echo 'make quick      the tests that need no build and no ROS'
	@echo 'make gate       the tests that know nothing of the modules'
	@echo 'make lint       ruff, mypy and codespell alone'
	@echo 'make coverage   what make quick covers, which must not drop'
	@echo 'make docs       the site, into build/site; needs no ROS'
	@echo 'make hostile    other users, faults, full disks, stale results'
	@echo 'make fuzz       the fuzz tests with 10,000 inputs each'
	@echo 'make soak       unruly launches and edits, MINUTES=3 SEED=1'
	@echo 'make clean      remove what was built, keep .venv'
	@echo 'make distclean  remove .venv too'

demo: $(VENV)/.installed
	@$(BIN)/python .ci/demo.py
	@echo
	@echo 'Go on by hand:'
	@echo '    source .venv/bin/activate && cd sample_ws'
	@echo '    colcon launch my_pkg demo.yaml'

test: lint
	@echo 'All tests, ten to fifteen minutes on two cores; the first line takes one.'
	$(BIN)/pytest -n auto --dist loadgroup

quick: $(VENV)/.test-dependencies $(VENV)/.installed
	HYPOTHESIS_PROFILE=quick \
		$(BIN)/pytest -n auto --dist loadgroup -m 'not full'

# Of the lines and branches that run in the processes of the tests; what
# launches, workers and agents run in processes of their own counts as missed.
coverage: $(VENV)/.test-dependencies $(VENV)/.installed
	HYPOTHESIS_PROFILE=quick \
		$(BIN)/pytest -n auto --dist loadgroup -m 'not full' \
		--cov --cov-report=html:build/coverage

# The contract of a change that only moves code: these tests stay as they are.
gate: $(VENV)/.test-dependencies $(VENV)/.installed
	$(BIN)/pytest -n auto --dist loadgroup -m 'contract or hostile'

lint: $(VENV)/.test-dependencies $(VENV)/.installed
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/codespell
	$(BIN)/codespell --skip= --ignore-words=tests/misspelled.txt tests

# All of it each time, as warnings of a page come only when it is read.
docs: $(VENV)/.docs-dependencies
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet \
		--fresh-env --write-all -d build/doctrees -c docs/site . $(SITE)
	@echo 'The site is $(SITE)/index.html.'

hostile: $(VENV)/.test-dependencies $(VENV)/.installed
	$(BIN)/pytest -n auto --dist loadgroup -m hostile

fuzz: $(VENV)/.test-dependencies $(VENV)/.installed
	HYPOTHESIS_PROFILE=long $(BIN)/pytest -n auto tests/language -k fuzz
	HYPOTHESIS_PROFILE=long $(BIN)/pytest -n auto tests/watch
	HYPOTHESIS_PROFILE=long $(BIN)/pytest -rP \
		tests/workspace/freshness/test_freshness_properties.py

soak: $(VENV)/.test-dependencies $(VENV)/.installed
	SOAK_MINUTES=$(MINUTES) SOAK_SEED=$(SEED) $(BIN)/pytest -n 2 \
		--dist loadgroup tests/engine/test_soak.py \
		tests/verb/watching/test_random_edits.py

clean:
	rm -rf build deb_dist dist *.egg-info $(COLCON_PRODUCTS)
	rm -rf .coverage .hypothesis .mypy_cache .pytest_cache .ruff_cache

distclean: clean
	rm -rf $(VENV)

# Not editable: the demo and the tests run what a user gets.
$(VENV)/.installed: $(VENV)/.dependencies $(SOURCES) README.md
	@$(PIP_INSTALL) --no-build-isolation --no-deps --force-reinstall .
	@touch $@

# setuptools below 80 still has what colcon needs for --symlink-install, and
# from 70.1 on it needs no `wheel` package. The pip of an older Python takes
# half as long again to choose among the files of the index.
$(VENV)/.dependencies: setup.cfg setup.py | $(BIN)/python
	@echo 'Installing ROS 2 and colcon into $(VENV), some 400 MB…'
	@$(PIP_INSTALL) --upgrade pip 'setuptools>=70.1,<80'
	@$(PIP_INSTALL) --no-build-isolation '.[common,ros]'
	@command -v cmake >/dev/null || $(PIP_INSTALL) cmake
	@touch $@

$(VENV)/.test-dependencies: $(VENV)/.dependencies
	@echo 'Installing what the tests use into $(VENV)…'
	@$(PIP_INSTALL) --no-build-isolation '.[test]'
	@touch $@

$(VENV)/.docs-dependencies: setup.cfg | $(BIN)/python
	@echo 'Installing what the site is built with into $(VENV)…'
	@$(PIP_INSTALL) '.[docs]'
	@touch $@

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit( \
		not (3, 10) <= sys.version_info[:2] <= (3, 13))' \
		|| { echo '$(PYTHON) is missing or not Python 3.10 to 3.13, for' \
		'which there are ROS 2 wheels: make PYTHON=python3.12 …' >&2; \
		exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
		|| { echo '$(PYTHON) cannot make virtual environments:' \
		'sudo apt install python3-venv' >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

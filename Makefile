# Every target does its own set-up in .venv; the second time that costs nothing.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
MAKEFLAGS += --no-print-directory

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet --quiet
UV = $(BIN)/uv pip install --quiet --python $(BIN)/python
READY := $(VENV)/.ready

# Workers of the test run, and the folder with the outside data sets (tests skip without it).
WORKERS ?= 2
COHELM_DATA ?= $(wildcard $(abspath ../shared/data))
export COHELM_DATA

# The rider's page: what npm brings, what it is built from, and what comes out.
PACKAGES := page/node_modules/.package-lock.json
SOURCES = $(shell find page -path page/node_modules -prune -o -type f \
    ! -name messages.ts ! -name measures.ts ! -name '*.test.ts' ! -name '*.md' ! -name '*.local' -print)
PAGE := src/cohelm/web/page/index.html
CHROMIUM := /usr/bin/chromium
FASTDDS := /usr/include/fastdds

# Options of "make run", as in: make run DRIVE="crossing --seed 3 --open"
DRIVE ?=

RIDES := rides
KERNELS := $(CURDIR)/build/kernels


.PHONY: help
help: ## this list
	@echo "make <target>, one of"
	@sed -nE 's/^([a-z-]+):.*## (.*)$$/  \1\t\2/p' $(MAKEFILE_LIST) | expand -t 14

.PHONY: run
run: setup ## drive the chair yourself, in the browser
	@if [ ! -f $(PAGE) ]; then echo "building the page (npm and vite)" >&2; fi
	@$(BIN)/cohelm compile > $(VENV)/compile.log 2>&1 & compile=$$!; \
	    trap 'kill $$compile 2> /dev/null || true' EXIT; \
	    $(MAKE) page > $(VENV)/page.log 2>&1 || { cat $(VENV)/page.log >&2; exit 1; }
	@$(BIN)/cohelm drive $(DRIVE)

.PHONY: ready
ready: setup ## the page built and all code compiled, side by side
	@$(MAKE) page > $(VENV)/page.log 2>&1 & page=$$!; trap 'kill $$page 2> /dev/null || true' EXIT; \
	    $(BIN)/cohelm compile; \
	    if kill -0 $$page 2> /dev/null; then echo "waiting for: the page (npm and vite)" >&2; fi; \
	    wait $$page || { cat $(VENV)/page.log >&2; exit 1; }

.PHONY: demo
demo: setup ## a ride across a hospital floor in the terminal, with a picture and an animation
	@mkdir -p $(RIDES)
	$(BIN)/cohelm run hospital --rider nudge \
	    --plot $(RIDES)/hospital.png --animate $(RIDES)/hospital.gif

.PHONY: page
page: $(PAGE) ## the rider's page, built where its sources have changed

.PHONY: test
test: ready chromium ## the tests, without the slow ones
	cd page && npm run --silent test
	$(BIN)/pytest -n $(WORKERS) -m "not slow"

.PHONY: test-slow
test-slow: setup page chromium fastdds ## the slow tests
	$(BIN)/pytest -n $(WORKERS) -m slow

.PHONY: check
check: setup $(PACKAGES) ## style, types and layers
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	cd page && npm run --silent check

.PHONY: bench
bench: setup ## the benchmarks, beside their outside references where there are any
	@echo "== cohelm bench simulation"; $(BIN)/cohelm bench simulation --out $(RIDES)/simulation
	@echo "== cohelm bench planning"; $(BIN)/cohelm bench planning --out $(RIDES)/planning
	@echo "== cohelm bench solver"; $(BIN)/cohelm bench solver --share 0.2 --out $(RIDES)/solver

.PHONY: setup
setup: $(READY) ## .venv with the exact versions of requirements.lock

$(READY): requirements.lock pyproject.toml
	@echo "setting up $(VENV) with $(PYTHON)"
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	    || { echo "cohelm needs Python 3.11 or newer; say where: make setup PYTHON=..." >&2; exit 1; }
	@[[ -x $(BIN)/python ]] || "$(PYTHON)" -m venv $(VENV)
	@[[ -x $(BIN)/uv ]] || $(PIP) install "$$(grep '^uv==' requirements.lock)" \
	    || echo "uv could not be installed: pip does its work, more slowly" >&2
	@if [[ -x $(BIN)/uv ]]; then install=($(UV)); else install=($(PIP) install); fi; \
	    "$${install[@]}" --no-deps --requirement requirements.lock \
	    && "$${install[@]}" --no-deps --no-build-isolation --editable .
	@touch $@

$(PACKAGES): page/package.json page/package-lock.json
	@command -v npm > /dev/null || { echo "building the page needs Node 20.19 or newer with npm \
	(https://nodejs.org); an installed wheel of cohelm needs neither" >&2; exit 1; }
	@echo "fetching what the page is built with"
	@cd page && npm ci --loglevel=error
	@touch $@

$(PAGE): $(PACKAGES) $(SOURCES) src/cohelm/web/messages.schema.json src/cohelm/web/measures.json
	@echo "building the page"
	@cd page && npm run --silent types && npx --no-install vite build --logLevel warn
	@touch $@

.PHONY: chromium
chromium: ## a Chromium for the tests of the page, where there is none
	@[[ -x $(CHROMIUM) ]] || { \
	    echo "the tests of the page need Chromium: installing it"; \
	    as_root=; [[ $$(id -u) = 0 ]] || as_root="sudo -n"; \
	    $$as_root apt-get update -qq && $$as_root apt-get install -qq -y -o Dpkg::Use-Pty=0 chromium > /dev/null; } \
	    || { echo "no Chromium at $(CHROMIUM), and it could not be installed with apt-get: \
	install it by hand, as in: sudo apt-get install chromium" >&2; exit 1; }

.PHONY: fastdds
fastdds: ## Debian's Fast DDS for a test of ROS 2 topics, where there is none
	@[[ -e $(FASTDDS) ]] || { \
	    echo "a test of ROS 2 topics needs Fast DDS: installing it"; \
	    as_root=; [[ $$(id -u) = 0 ]] || as_root="sudo -n"; \
	    $$as_root apt-get update -qq && $$as_root apt-get install -qq -y -o Dpkg::Use-Pty=0 \
	        g++ libfastrtps-dev libfastcdr-dev > /dev/null; } \
	    || echo "no Fast DDS, and it could not be installed with apt-get: its test is skipped" >&2

.PHONY: wheel
wheel: setup page ## dist/*.whl with the built page and compiled kernels, for this Python and x86-64 Linux
	@rm -rf $(KERNELS)
	NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= NUMBA_CACHE_DIR=$(KERNELS) $(BIN)/cohelm compile
	COHELM_KERNELS=$(KERNELS)/cohelm $(BIN)/python -m hatchling build -t wheel

.PHONY: wheel-any
wheel-any: setup page ## dist/*.whl for any machine: the first ride compiles
	$(BIN)/python -m hatchling build -t wheel

.PHONY: schema
schema: setup ## the messages' JSON Schema again from src/cohelm/live/messages
	$(BIN)/python -m cohelm.web.schema

# What JuPedSim asks for and cohelm does not use: 1.2 GB.
UNUSED := pyside6 pyside6-addons pyside6-essentials shiboken6 vtk

.PHONY: lock
lock: setup ## requirements.lock again from pyproject.toml, with the newest versions
	@{ echo "# Exact versions of everything that cohelm is built, run and tested with."; \
	   echo "# Made by \"make lock\" from pyproject.toml; do not edit."; \
	   $(BIN)/pip-compile pyproject.toml --extra dev --upgrade --strip-extras --quiet \
	       --no-header --no-annotate --no-emit-options --no-emit-index-url \
	       --no-emit-trusted-host --no-emit-find-links --no-allow-unsafe \
	       --unsafe-package cohelm --unsafe-package pip --unsafe-package setuptools \
	       $(UNUSED:%=--unsafe-package %) \
	       --no-build-isolation --output-file - | grep -v -e '^#' -e '^$$'; \
	} > $(VENV)/requirements.lock
	@mv $(VENV)/requirements.lock requirements.lock

.PHONY: hooks
hooks: setup ## run the checks before every commit
	$(BIN)/pre-commit install

.PHONY: clean
clean: ## remove what the tools leave behind, keep .venv
	rm -rf .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache .benchmarks build dist out
	rm -rf page/node_modules src/cohelm/web/page src/cohelm/compiled.txt
	find src tests benchmarks examples -name __pycache__ -prune -exec rm -rf {} +

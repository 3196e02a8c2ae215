# Verbs of development; each is a command that can be run by itself. Variables: VENV, ARGS (of pytest), BENCHMARKS.
VENV ?= .venv
BIN = $(VENV)/bin
ARGS ?=
BENCHMARKS ?= accuracy atlas branch chart disturbances distortion explore extremes harmonics impacts maps startup validation

.PHONY: help setup test slow all lint format benchmarks docs site pictures schema ci

help: ## list the verbs
	@awk -F ':.*## ' '/^[a-z]+:.*## /{printf "%-10s %s\n", $$1, $$2}' Makefile

$(BIN)/vireport: pyproject.toml
	python3 -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	@touch $@

setup: $(BIN)/vireport ## make .venv with everything that development needs

test: setup ## the quick tests
	$(BIN)/python -m pytest -n auto -m "not slow" $(ARGS)

slow: setup ## the slow tests
	$(BIN)/python -m pytest -n auto -m slow $(ARGS)

all: setup ## all tests
	$(BIN)/python -m pytest -n auto $(ARGS)

lint: setup ## style, format, types, import contract
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy vireport
	$(BIN)/lint-imports
	$(BIN)/python tools/make_docs.py --check

format: setup ## format the code
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

benchmarks: setup ## measure the figures of docs/ anew, on an idle machine
	for name in $(BENCHMARKS); do $(BIN)/python benchmarks/$$name.py || exit 1; done
	$(BIN)/python tools/make_docs.py

docs: setup ## make docs/accuracy.md and docs/validation.md from what was recorded, and tables of keys from their records
	$(BIN)/python tools/make_docs.py

site: setup ## make the site of the documentation, build/site/index.html
	$(BIN)/python -m pip install --quiet --editable ".[docs]"
	$(BIN)/python tools/make_site.py

pictures: setup ## draw all pictures of the documentation anew, and measure what one of them shows
	$(BIN)/python tools/make_pictures.py
	$(BIN)/python benchmarks/accuracy.py
	$(BIN)/python tools/make_docs.py

schema: setup ## write what follows from keys: the JSON Schema that the examples name, and tables of docs/scenario.md
	$(BIN)/python tools/write_keys.py

ci: ## all that a change must pass, from a clean environment
	.ci/run

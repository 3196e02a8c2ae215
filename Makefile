# Verbs of development; each is a command that can be run by itself. Variables: VENV, ARGS (of pytest).
VENV ?= .venv
BIN = $(VENV)/bin
ARGS ?=

.PHONY: help setup test slow all lint format pictures schema ci

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

format: setup ## format the code
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

pictures: setup ## draw the pictures of the documentation anew
	$(BIN)/python tools/make_pictures.py

schema: setup ## write the JSON Schema that the examples name
	$(BIN)/vireport schema > examples/scenario.schema.json

ci: ## all that a change must pass, from a clean environment
	.ci/run

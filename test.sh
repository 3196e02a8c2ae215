#!/bin/sh
# Sets up an environment (by default .venv) and runs the tests in it, without those marked slow.
set -eu
cd "$(dirname "$0")"
venv="${1:-.venv}"
unset PYTHONDONTWRITEBYTECODE  # modules are compiled when they are first imported, and once
python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --no-compile --editable ".[dev]"
exec "$venv/bin/python" -m pytest -n auto -m "not slow"

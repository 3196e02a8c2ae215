#!/bin/sh
# Sets up an environment (by default .venv) and runs the tests in it, without those marked slow.
set -eu
cd "$(dirname "$0")"
venv="${1:-.venv}"
unset PYTHONDONTWRITEBYTECODE  # modules are compiled when they are first imported, and once
python3 -m venv "$venv"
python="$venv/bin/python"
# uv takes a few seconds for what takes pip most of a minute; where it cannot, pip does it.
{ "$python" -m pip install --quiet --no-compile uv &&
  "$python" -m uv pip install --quiet --python "$python" --editable ".[dev]"; } ||
  "$python" -m pip install --quiet --no-compile --editable ".[dev]"
exec "$python" -m pytest -n auto -m "not slow"

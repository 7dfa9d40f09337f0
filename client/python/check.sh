#!/usr/bin/env bash
# Builds the wheel and tests it as a user gets it, with the oldest and the newest libraries that it
# takes. Needs Rust, bash and Python 3.10 or newer, and fetches packages from PyPI. Settings:
# PYTHON_OLDEST and PYTHON_NEWEST name interpreters, WHEEL a wheel that is built already.
set -euo pipefail
cd "$(dirname "$0")"

oldest=${PYTHON_OLDEST:-python3}
newest=${PYTHON_NEWEST:-python3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

step() { printf '\n== %s\n' "$*"; }

# A virtual environment with the wheel: NAME INTERPRETER REQUIREMENTS...
environment() {
    "$2" -m venv "$work/$1"
    "$work/$1/bin/pip" --quiet install "$wheel" "${@:3}"
}

step wheel
wheel=${WHEEL:-}
if [ -z "$wheel" ]; then
    "$oldest" -m venv "$work/build"
    "$work/build/bin/pip" --quiet wheel --no-deps --config-settings portable=yes --wheel-dir "$work" .
    wheel=$(echo "$work"/signorini-*.whl)
fi
ls -l "$wheel"

step newest libraries
environment newest "$newest" pytest meshio matplotlib pyvista gmsh mypy ruff types-protobuf
"$work/newest/bin/pip" list --format freeze | grep --extended-regexp '^(grpcio|protobuf|numpy)='
(cd tests && "$work/newest/bin/pytest" --quiet)

step types and style
"$work/newest/bin/ruff" check .
"$work/newest/bin/ruff" format --check .
"$work/newest/bin/mypy" --package signorini
# From elsewhere, so that the types are those of the wheel.
examples=$PWD/examples
(cd "$work" && newest/bin/mypy --strict --ignore-missing-imports \
    "$examples"/{o_ring,own_o_ring,numpy_block,updates,sweep,coupled}.py)

step examples
for example in o_ring own_o_ring numpy_block sweep coupled; do
    "$work/newest/bin/python" "examples/$example.py"
done
"$work/newest/bin/python" examples/updates.py ../examples/hertz-sphere.toml ../examples/meshes/indent_l1.msh

step oldest libraries
environment oldest "$oldest" pytest 'grpcio==1.60.*' 'protobuf==4.25.*' 'googleapis-common-protos==1.60.*' \
    'numpy==1.24.*' 'tomli-w==1.0.*'
"$work/oldest/bin/pip" list --format freeze | grep --extended-regexp '^(grpcio|protobuf|numpy)='
(cd tests && "$work/oldest/bin/pytest" --quiet)

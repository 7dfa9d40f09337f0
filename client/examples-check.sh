#!/usr/bin/env bash
# Runs the clients that use the .proto files alone, in C++ and in Python, against a server of
# their own, and compares their forces with that of `signorini solve`. Settings: SIGNORINI
# names the binary (built otherwise), PYTHON an interpreter. Fetches packages from PyPI; says
# what it could not try.
set -euo pipefail
cd "$(dirname "$0")"

mesh=examples/meshes/indent_l1.msh
work=$(mktemp -d)
server=
trap 'test -z "$server" || kill "$server"; rm -rf "$work"' EXIT

step() { printf '\n== %s\n' "$*"; }

signorini=${SIGNORINI:-}
if [ -z "$signorini" ]; then
    step build
    cargo build --release --bin signorini
    signorini=$(cargo metadata --format-version 1 --no-deps |
        sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release/signorini
fi

step server
"$signorini" serve --listen "unix:$work/socket" --metrics-listen "" &
server=$!
for _ in $(seq 100); do test -S "$work/socket" && break; sleep 0.1; done

# The force along z of the last result.
expected=$("$signorini" solve examples/hertz-sphere.toml --set "mesh=$mesh" --json --quiet |
    sed -n 's/.*"event":"step".*"ball":{"force":\[[^,]*,[^,]*,\([^]]*\)\].*/\1/p' | tail -1)
echo "signorini solve: $expected"

# compare NAME OUTPUT: the third number behind `force` in its first line.
compare() {
    echo "$2"
    echo "$2" | tr -d '[],' | awk -v name="$1" -v expected="$expected" '
        /force/ { found = 1; error = ($5 - expected) / expected
                  if (error < 0) error = -error
                  if (!/CONVERGED/ || error > 1e-9) { print name ": another force"; exit 1 } }
        END { if (!found) exit 1 }'
}

step "C++"
if command -v cmake >/dev/null && command -v grpc_cpp_plugin >/dev/null; then
    cmake -S cpp -B "$work/cpp" -DCMAKE_BUILD_TYPE=Release >"$work/cmake.log"
    cmake --build "$work/cpp" --parallel 2 >>"$work/cmake.log" || { cat "$work/cmake.log"; exit 1; }
    compare C++ "$("$work/cpp/hertz_sphere" "unix:$work/socket" "$mesh")"
else
    echo "not tried: cmake or grpc_cpp_plugin is missing (see cpp/README.md)"
fi

step Python
if "${PYTHON:-python3}" -m venv "$work/python"; then
    "$work/python/bin/pip" --quiet install grpcio grpcio-tools googleapis-common-protos meshio numpy
    cp python/examples/plain_stubs.py "$work"
    mkdir "$work/stubs"
    "$work/python/bin/python" -m grpc_tools.protoc -I ../proto --python_out="$work/stubs" \
        --grpc_python_out="$work/stubs" ../proto/signorini/v1/*.proto
    compare Python "$("$work/python/bin/python" "$work/plain_stubs.py" --server "unix:$work/socket" --mesh "$mesh")"
else
    echo "not tried: no Python with venv"
fi

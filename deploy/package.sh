#!/usr/bin/env bash
# Makes target/package/signorini-VERSION-TARGET.tar.gz: the stripped release program, licence,
# README, manual, completions, settings and unit. Needs the Rust toolchain and strip.
#
#   deploy/package.sh            all of the program
#   deploy/package.sh --lean     without the command `bench`
#
# With cargo-zigbuild on the path (pip install cargo-zigbuild) the
# program runs on every Linux from glibc 2.28 on; without, on those at least as new as this.
# The kernels for AVX2 and AVX-512 are in it and chosen at run time: it needs no more of the
# processor than its architecture has.
set -euo pipefail
cd "$(dirname "$0")/.."

features=(--features default)
suffix=
case "${1:-}" in
    '') ;;
    --lean)
        features=(--no-default-features --features embedded)
        suffix=-lean
        ;;
    *)
        echo "usage: $0 [--lean]" >&2
        exit 2
        ;;
esac

glibc=2.28
target_dir=${CARGO_TARGET_DIR:-target}
host=$(rustc -vV | sed -n 's/^host: //p')
version=$(sed -n '/^\[workspace.package\]/,/^\[/ s/^version = "\(.*\)"/\1/p' Cargo.toml)
build=(--release --locked --package signorini-client --bin signorini "${features[@]}")

if [[ $host == *-linux-gnu ]] && cargo zigbuild --version >/dev/null 2>&1; then
    cargo zigbuild --target "$host.$glibc" "${build[@]}"
    program=$target_dir/$host/release/signorini
else
    cargo build "${build[@]}"
    program=$target_dir/release/signorini
fi

name=signorini-$version-$host$suffix
folder=$target_dir/package/$name
rm -rf "$folder"
mkdir -p "$folder/completions" "$folder/deploy"
cp "$program" "$folder/signorini"
strip --strip-all "$folder/signorini"
cp LICENSE README.md "$folder"
cp -r client/manual "$folder/manual"
cp deploy/server.toml deploy/signorini.service "$folder/deploy"
for shell in bash zsh fish; do
    "$folder/signorini" completions "$shell" >"$folder/completions/signorini.$shell"
done

tar --create --gzip --owner=0 --group=0 --sort=name \
    --mtime="@$(git log -1 --format=%ct 2>/dev/null || date +%s)" \
    --file "$folder.tar.gz" --directory "$target_dir/package" "$name"

needs=$(objdump -T "$folder/signorini" 2>/dev/null | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -1 || true)
echo "program $(stat -c %s "$folder/signorini") bytes, archive $(stat -c %s "$folder.tar.gz") bytes, needs ${needs:-an unknown glibc}"
echo "$folder.tar.gz"

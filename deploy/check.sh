#!/usr/bin/env bash
# Checks what is in this folder as far as this machine can, and says what it could not try.
#
#   deploy/check.sh [PROGRAM]
#
# PROGRAM is a built `signorini`; without one, what needs it is left out. Uses promtool and
# prometheus (Debian: apt install prometheus), systemd-analyze, podman, buildah or docker,
# docker compose, each where it is there. Run as root it also starts the program as the
# image would: in an otherwise empty folder, as user 65532.
# Functions are called by name:
# shellcheck disable=SC2317
set -uo pipefail
cd "$(dirname "$0")" || exit 1

program=${1:+$(realpath "$1")}
failed=0 untried=()

check() { # WHAT COMMAND...
    local what=$1 output
    shift
    if output=$("$@" 2>&1); then
        echo "ok       $what"
    else
        failed=1
        printf 'FAILED   %s\n%s\n' "$what" "$output"
    fi
}
skip() { untried+=("$1"); }
have() { command -v "$1" >/dev/null 2>&1; }

if have promtool; then
    check "Prometheus: settings" promtool check config prometheus/prometheus.yml
    check "Prometheus: rules" promtool check rules prometheus/rules.yml prometheus/alerts.yml
    check "Prometheus: tests of the alerts" promtool test rules prometheus/tests.yml
else
    skip "rules and alerts: no promtool here"
fi

# Every alert is in the manual, and provoked by the drill.
check_alerts() {
    local name
    for name in $(sed -n 's/^ *- alert: //p' prometheus/alerts.yml); do
        grep -q "\`$name\`" ../client/manual/operations.md || { echo "$name is not in operations.md"; return 1; }
        grep -q "\"$name\"" ../tests/benches/service/{faults,spoilt}.py || { echo "no fault for $name"; return 1; }
    done
}
if [[ -d ../tests/benches/service ]]; then
    check "alerts: told in the manual, and provoked by the drill" check_alerts
else
    skip "alerts against the manual and the drill: not in the sources"
fi

check_dashboards() {
    python3 - <<'PY'
import json, pathlib, re
seen, asked = {}, pathlib.Path("prometheus/rules.yml").read_text()
for path in sorted(pathlib.Path("grafana/dashboards").glob("*.json")):
    board = json.loads(path.read_text())
    assert board["uid"] not in seen, f"{path}: uid of {seen[board['uid']]}"
    seen[board["uid"]] = path
    ids = [panel["id"] for panel in board["panels"]]
    assert len(ids) == len(set(ids)), f"{path}: panel ids"
    for panel in board["panels"]:
        at = panel["gridPos"]
        assert at["x"] + at["w"] <= 24, f"{path}: {panel['title']} is outside the grid"
        assert panel["targets"], f"{path}: {panel['title']} asks for nothing"
        for target in panel["targets"]:
            assert target["datasource"]["uid"] == "${datasource}", f"{path}: {panel['title']}"
            asked += target["expr"]
assert len(seen) == 7, seen
# Every metric has a panel, where the sources that name them are here.
for path in pathlib.Path("../server/src/watch/metrics").glob("*.rs"):
    for name in re.findall(r'const \w+: &str = "(signorini_\w+)"', path.read_text()):
        assert name in asked, f"{name} has no panel"
PY
}
if have python3; then
    check "Grafana: dashboards are well formed" check_dashboards
else
    skip "dashboards: no python3 here"
fi

# The job of Slurm with a stand-in for srun, which shows what it would start.
check_slurm() {
    local folder told
    folder=$(mktemp -d)
    printf '#!/bin/sh\nprintf "%%s " "$@"\n' >"$folder/srun"
    chmod +x "$folder/srun"
    told=$(PATH="$folder:$PATH" SLURM_CPUS_PER_TASK=2 bash slurm/workers.sh nats://queue:4222 --verbose)
    rm -r "$folder"
    printf '%s\n' "$told"
    [[ $told == *" signorini worker --queue nats://queue:4222 --threads 2 --idle 300 --verbose "* ]] || return 1
    ! bash slurm/workers.sh 2>/dev/null || return 1
    # Every flag is one of the program.
    [[ -z $program ]] || "$program" worker --queue x --threads 2 --idle 300 --metrics 127.0.0.1:0 --help
}
check "Slurm: the job of workers" check_slurm
if have shellcheck; then
    check "shell scripts" shellcheck slurm/workers.sh check.sh package.sh
else
    skip "shell scripts: no shellcheck here"
fi

# What the unit would run is there in a real installation; here it stands in.
check_unit() {
    local folder
    folder=$(mktemp -d)
    sed "s|/usr/local/bin/signorini|$(command -v true)|" signorini.service >"$folder/signorini.service"
    local output
    output=$(systemd-analyze verify "$folder/signorini.service" 2>&1)
    local code=$?
    rm -r "$folder"
    printf '%s\n' "$output"
    [[ $code == 0 && -z $output ]]
}
if have systemd-analyze; then
    check "systemd: the unit" check_unit
    if [[ $(systemd-analyze --version | sed -n '1s/^systemd \([0-9]*\).*/\1/p') -ge 250 ]]; then
        # 1.1 with PrivateUsers=yes, which would make all users of the machine one client.
        check "systemd: exposure at most 1.4 of 10" \
            systemd-analyze security --offline=true --threshold=14 ./signorini.service
    else
        skip "exposure of the unit: systemd before 250"
    fi
else
    skip "the unit: no systemd-analyze here"
fi
skip "the unit started by systemd: only an installation shows that"

if docker compose version >/dev/null 2>&1; then
    check "compose.yaml" docker compose -f compose.yaml config --quiet
else
    skip "compose.yaml by docker compose, which is not here"
fi
check_yaml() {
    python3 - <<'PY'
import pathlib, yaml
for path in [pathlib.Path("compose.yaml"), *pathlib.Path(".").glob("*/**/*.yml")]:
    yaml.safe_load(path.read_text())
compose = yaml.safe_load(open("compose.yaml"))
for path in pathlib.Path("kubernetes").glob("*.yml"):
    one = yaml.safe_load(path.read_text())
    pod = one["spec"]["template"]
    chosen = one["spec"]["selector"]["matchLabels"]
    assert chosen.items() <= pod["metadata"]["labels"].items(), f"{path}: selects other pods"
    for container in pod["spec"]["containers"]:
        names = {port["name"] for port in container["ports"]}
        assert container["livenessProbe"]["httpGet"]["port"] in names, f"{path}: probes no port"
        port = pod["metadata"]["annotations"]["prometheus.io/port"]
        assert any(f":{port}" in one for one in container["args"]), f"{path}: shows no metrics"
for name, service in compose["services"].items():
    assert service["network_mode"] == "host", f"{name}: has to share the network"
    for volume in service.get("volumes", []):
        source = volume.split(":")[0]
        if source.startswith("./"):
            assert pathlib.Path(source).exists(), f"{name}: {source} is missing"
        else:
            assert source in compose["volumes"], f"{name}: volume {source}"
PY
}
if python3 -c "import yaml" 2>/dev/null; then
    check "YAML files, and what compose.yaml mounts" check_yaml
else
    skip "YAML files: no python3-yaml here"
fi

builder=
for one in podman buildah docker; do
    if have "$one" && "$one" info >/dev/null 2>&1; then
        builder=$one
        break
    fi
done
can_build() { timeout 60 "$builder" pull gcr.io/distroless/cc-debian12:nonroot >/dev/null 2>&1; }
if [[ -z $builder ]]; then
    skip "the image: no podman, buildah or running docker here"
elif ! can_build; then
    skip "the image itself: $builder is here, its base images cannot be fetched"
elif [[ $builder == docker ]]; then
    check "the image" docker build -f Containerfile -t signorini ..
else
    check "the image" "$builder" build --format docker -f Containerfile -t signorini ..
fi

# Every step of the Containerfile by buildah, with stand-ins for the base images: busybox
# with a cargo that hands out PROGRAM, and the libraries of PROGRAM.
image_of_stand_ins() {
    local store=$1 made root library
    export BUILDAH_ISOLATION=chroot
    local buildah=(buildah --storage-driver vfs --root "$store/root" --runroot "$store/run")
    made=$("${buildah[@]}" from scratch) && root=$("${buildah[@]}" mount "$made") || return 1
    mkdir -p "$root"/bin "$root"/src "$root"/tmp
    cp "$(command -v busybox)" "$root/bin/busybox"
    for one in sh cp mkdir; do ln -s busybox "$root/bin/$one"; done
    cp "$program" "$root/prebuilt"
    strip --strip-all "$root/prebuilt"
    printf '#!/bin/sh\nmkdir -p target/release\ncp /prebuilt target/release/signorini\n' >"$root/bin/cargo"
    printf '#!/bin/sh\n' >"$root/bin/strip"
    chmod +x "$root/bin/cargo" "$root/bin/strip"
    "${buildah[@]}" config --env PATH=/bin "$made"
    "${buildah[@]}" commit --quiet --rm "$made" "$(sed -n 's/^FROM \(.*\) AS build$/\1/p' Containerfile)" || return 1
    made=$("${buildah[@]}" from scratch) && root=$("${buildah[@]}" mount "$made") || return 1
    for library in $(ldd "$program" | grep -o '/[^ ]*'); do
        install -D "$(realpath "$library")" "$root$library"
    done
    "${buildah[@]}" commit --quiet --rm "$made" "$(sed -n 's/^FROM //p' Containerfile | tail -1)" || return 1
    "${buildah[@]}" build --pull=never --format docker -f Containerfile -t signorini .. || return 1
    made=$("${buildah[@]}" from --pull=never signorini) || return 1
    "${buildah[@]}" run "$made" -- /usr/local/bin/signorini serve --help
}
if [[ -n $program && $(id -u) == 0 ]] && have buildah && have busybox; then
    store=$(mktemp -d)
    check "the Containerfile, with stand-ins for its base images" image_of_stand_ins "$store"
    rm -rf "$store"
else
    skip "the Containerfile with stand-ins: needs PROGRAM, root, buildah and busybox"
fi

# The last stage of the Containerfile by hand: program, settings and the libraries of the
# base image in an empty folder, started and asked as the image would be.
image_by_hand() {
    local root=$1 library
    mkdir -p "$root"/{usr/local/bin,etc/signorini,proc,tmp}
    cp "$program" "$root/usr/local/bin/signorini"
    strip --strip-all "$root/usr/local/bin/signorini"
    cp server.toml "$root/etc/signorini/"
    for library in $(ldd "$program" | grep -o '/[^ ]*'); do
        case ${library##*/} in
            libc.so.* | libm.so.* | libgcc_s.so.* | ld-linux*) ;;
            *)
                echo "the base image lacks $library"
                return 1
                ;;
        esac
        install -D "$(realpath "$library")" "$root$library"
    done
    chmod -R a+rX "$root"
    local inside=(timeout 60 chroot --userspec=65532:65532 "$root" /usr/local/bin/signorini)
    # The command of the image, but for ports that may be taken here.
    local url server code=1
    coproc exec "${inside[@]}" serve --config /etc/signorini/server.toml \
        --listen 127.0.0.1:0 --metrics-listen ""
    server=$COPROC_PID
    read -r -t 20 url <&"${COPROC[0]}"
    # The health check of the image.
    "${inside[@]}" session list --server "$url" && code=0
    kill "$server"
    wait "$server" 2>/dev/null
    return "$code"
}
if [[ -z $program ]]; then
    skip "the program as in the image, dashboards with data: no PROGRAM given"
elif [[ $(id -u) != 0 ]]; then
    skip "the program as in the image: needs root for chroot"
else
    root=$(mktemp -d)
    check "the program alone in a folder, as user 65532, with its health check" image_by_hand "$root"
    echo "         program and libraries: $(du -sk "$root" | cut -f1) KiB"
    rm -r "$root"
fi
if [[ -n $program ]]; then
    if have prometheus && have python3; then
        check "every panel has data from a server at work (a minute)" python3 try_dashboards.py "$program"
    else
        skip "panels with data: no prometheus or python3 here"
    fi
fi
skip "dashboards drawn by Grafana itself: start compose.yaml and look"

printf 'not tried: %s\n' "${untried[@]}"
exit $failed

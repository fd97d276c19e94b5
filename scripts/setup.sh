#!/usr/bin/env bash
# Makes the environment in .venv: pinned packages from the registries and the suite's own packages (editable).
# A second call finds the stamp and returns at once. PYTHON=python3.12 scripts/setup.sh takes another interpreter.
set -u
cd "$(dirname "$0")/.." || exit 1

PYTHON=${PYTHON:-python3}
STAMP=.venv/setup.stamp
LOG=.setup/install.log
PACKAGES="softhand_model softhand_ros pneuflex_sim pneumaticbox_driver grasp_strategies model_lab softhand_bringup softhand_play"

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }

# What the environment was made from; a change of any of it makes the stamp stale.
fingerprint() {
    { pwd; cat requirements/*.txt src/*/setup.py scripts/setup.sh; } | sha256sum
}

check_platform() {
    case "$(uname -s)-$(uname -m)" in
        Linux-x86_64) ;;
        *) fail "ROS 2 from PyPI has wheels for x86-64 Linux only, this is $(uname -s) $(uname -m)" ;;
    esac
}

# Names everything that is missing in one go, with the line that installs it.
check_system() {
    local missing=() version
    command -v make >/dev/null || missing+=(make)
    if ! command -v "$PYTHON" >/dev/null; then
        missing+=(python3 python3-venv)
    else
        version=$("$PYTHON" -c 'import sys; print("%d%02d" % sys.version_info[:2])')
        [ "$version" -ge 311 ] || fail "needs Python 3.11 or later, $PYTHON is $("$PYTHON" -V)"
        "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || missing+=(python3-venv)
        if [ "$version" -gt 311 ]; then  # PyBullet has wheels up to 3.11 only
            command -v g++ >/dev/null || missing+=(g++)
            "$PYTHON" -c 'import os, sysconfig as s; os.stat(s.get_path("include") + "/Python.h")' \
                2>/dev/null || missing+=(python3-dev)
        fi
    fi
    [ ${#missing[@]} -eq 0 ] ||
        fail "missing: ${missing[*]}. Install with: sudo apt-get install -y ${missing[*]}"
    [ "${version:-0}" -le 311 ] ||
        say "PyBullet has no wheel for $("$PYTHON" -V): it is built from source, which takes several minutes"
}

# One line that moves on a terminal; in a log, one line every 15 s.
show_progress() {
    local pid=$1 what=$2 start=$SECONDS last=-15 spent count step
    while kill -0 "$pid" 2>/dev/null; do
        spent=$((SECONDS - start))
        count=$(grep -c '^ *Collecting' "$LOG")
        step=$(grep -E '^ *(Collecting|Using cached|Downloading|Building|Installing|Running)' "$LOG" |
            tail -n 1 | sed 's/^ *//' | cut -c 1-50)
        if [ -t 1 ]; then
            printf '\r\033[Ksetup: %s: %d s, %d packages found; %s' "$what" "$spent" "$count" "$step"
            sleep 0.5
        else
            [ $((spent - last)) -lt 15 ] || { last=$spent; say "$what: $spent s, $count packages found; $step"; }
            sleep 1
        fi
    done
    [ ! -t 1 ] || printf '\r\033[K'
}

# pip's own words stay in the log; the user gets one line that says what went wrong.
explain_failure() {
    if grep -qE 'NewConnectionError|NameResolutionError|ConnectTimeout|ProxyError|Network is unreachable|Temporary failure in name resolution' "$LOG"; then
        fail "no network: the package registry did not answer (pip's log: $LOG)"
    fi
    fail "$1 failed: $(grep -E '^ *(ERROR|error)' "$LOG" | tail -n 1 | cut -c 1-200) (log: $LOG)"
}

run_pip() {
    local what=$1
    shift
    : > "$LOG"
    .venv/bin/python -m pip install --disable-pip-version-check --no-input --retries 2 \
        --progress-bar off "$@" > "$LOG" 2>&1 &
    local pid=$!
    trap 'kill $pid 2>/dev/null; exit 130' INT TERM
    show_progress "$pid" "$what"
    wait "$pid" || explain_failure "$what"
    trap - INT TERM
}

# What nodes and lab would else do at their first start.
compile_kernels() {
    say "compiling the numerical kernels (about a minute; this happens once)"
    .venv/bin/python scripts/precompile.py > "$LOG" 2>&1 || explain_failure "compiling the kernels"
}

make_environment() {
    local start=$SECONDS sources=() name
    mkdir -p .setup
    if ! .venv/bin/python -c 'import pip' 2>/dev/null; then
        say "making .venv with $("$PYTHON" -V) (about 1 GB; this happens once)"
        "$PYTHON" -m venv --clear .venv > "$LOG" 2>&1 || explain_failure "making .venv"
    fi
    run_pip "installing ROS 2 Jazzy and the tools" -r requirements/develop.txt
    for name in $PACKAGES; do
        sources+=(-e "src/$name")
    done
    run_pip "installing the suite" --no-deps --no-build-isolation --use-pep517 \
        --config-settings editable_mode=compat "${sources[@]}"
    compile_kernels
    fingerprint > "$STAMP"
    say "done in $((SECONDS - start)) s"
}

if [ ! -x .venv/bin/python ] || [ "$(cat "$STAMP" 2>/dev/null)" != "$(fingerprint)" ]; then
    check_platform
    check_system
    make_environment
fi

#!/usr/bin/env bash
# Makes the environment in .venv: packages from the registries, each with a hash of requirements/lock, and the
# suite's own packages (editable).
# A second call finds the stamp and returns at once. PYTHON=python3.12 scripts/setup.sh takes another interpreter.
set -u
cd "$(dirname "$0")/.." || exit 1

PYTHON=${PYTHON:-python3}
STAMP=.venv/setup.stamp
LOG=.setup/install.log
PACKAGES="softhand_common softhand_model softhand_ros pneuflex_sim softhand_design pneumaticbox_driver grasp_strategies softhand_trials model_lab softhand_bringup softhand_gym softhand_play"

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }

# What the environment was made from; a change of any of it makes the stamp stale.
fingerprint() {
    { pwd; cat requirements/lock/*.txt src/*/setup.py scripts/setup.sh; } | sha256sum
}

check_platform() {
    case "$(uname -s)-$(uname -m)" in
        Linux-x86_64) ;;
        *) fail "ROS 2 from PyPI has wheels for x86-64 Linux only, this is $(uname -s) $(uname -m)" ;;
    esac
}

# The packages for an interpreter, with hashes: requirements/lock/3.11.txt.
lock_of() {
    "$1" -c 'import sys; print("requirements/lock/%d.%d.txt" % sys.version_info[:2])'
}

# Names everything that is missing in one go, with the line that installs it.
check_system() {
    local missing=() locked
    command -v make >/dev/null || missing+=(make)
    if ! command -v "$PYTHON" >/dev/null; then
        missing+=(python3 python3-venv)
    else
        locked=$(lock_of "$PYTHON")
        [ -f "$locked" ] || fail "$PYTHON is $("$PYTHON" -V): expected a version that has a $locked"
        "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || missing+=(python3-venv)
    fi
    [ ${#missing[@]} -eq 0 ] ||
        fail "missing: ${missing[*]}. Install with: sudo apt-get install -y ${missing[*]}"
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

# Name and hash of a package that differs from the lock, from pip's lines about it.
differing_package() {
    sed -n '/DO NOT MATCH THE HASHES/,$p' "$LOG" | sed -nE 's/^ +([^ ]+==[^ ]+) from .*/\1: got sha256/p; s/^ +Got +//p' |
        head -n 2 | tr '\n' ' '
}

# pip's own words stay in the log; the user gets one line that says what went wrong.
explain_failure() {
    if grep -qE 'NewConnectionError|NameResolutionError|ConnectTimeout|ProxyError|Network is unreachable|Temporary failure in name resolution' "$LOG"; then
        fail "no network: the package registry did not answer (pip's log: $LOG)"
    fi
    if grep -q 'DO NOT MATCH THE HASHES' "$LOG"; then
        fail "refused: expected a hash of requirements/lock for $(differing_package)(log: $LOG)"
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
    run_pip "installing the build tools" --require-hashes --no-deps -r requirements/lock/build.txt
    # The lock names every package; pip 23 would look beyond it for a newer coverage[toml], an extra of one it names.
    run_pip "installing ROS 2 Jazzy and the tools" --require-hashes --no-deps --no-build-isolation \
        -r "$(lock_of .venv/bin/python)"
    for name in $PACKAGES; do
        sources+=(-e "src/$name")
    done
    run_pip "installing the suite" --no-deps --no-build-isolation --use-pep517 \
        --config-settings editable_mode=compat "${sources[@]}"
    compile_kernels
    fingerprint > "$STAMP"
    say "done in $((SECONDS - start)) s"
}

[ ! -L .venv ] || fail ".venv: expected a folder of this project, got a link to $(readlink .venv); remove the link and call again"
if [ ! -x .venv/bin/python ] || [ "$(cat "$STAMP" 2>/dev/null)" != "$(fingerprint)" ]; then
    check_platform
    check_system
    make_environment
fi

# Sourced by the scripts beside it: each sets an engine up in a folder of its own, runs a comparison and a catalogue
# in parts on it, kills some of them, resubmits, merges, and compares the results with those of one run.
#
# SPHVAR is the command [default: a release build]. Exit status 1 means that something differs or that the engine is
# unavailable; with SPHVAR_CLUSTER_OPTIONAL=1 an engine that is unavailable is a message and status 0.

source "$(dirname "${BASH_SOURCE[0]}")/../.ci/common.sh"

parts=16
python=python3
tools=$PWD/cluster

# unavailable MESSAGE: ends the script where the engine cannot be set up.
unavailable() {
    if [ "${SPHVAR_CLUSTER_OPTIONAL:-}" = 1 ]; then
        echo "Skipped: $1"
        exit 0
    fi
    fail "$1"
}

say() {
    printf '%s  %s\n' "$(date +%T)" "$*"
}

pass() {
    printf 'PASS  %s\n' "$*"
}

# seconds START: the time since then, a value of EPOCHREALTIME, to a tenth.
seconds() {
    awk -v start="$1" -v end="$EPOCHREALTIME" 'BEGIN { printf "%.1f", end - start }'
}

# within SECONDS COMMAND...: waits until the command succeeds.
within() {
    local end=$((SECONDS + $1))
    shift
    until "$@"; do
        [ "$SECONDS" -lt "$end" ] || return 1
        sleep 0.05
    done
}

# Prints the ids of the processes of the engine and of the parts, which have inherited the variable of `marked`.
processes() {
    { grep -lzs "^SPHVAR_CLUSTER=$place\$" /proc/[0-9]*/environ || true; } | cut -d / -f 3
}

# marked COMMAND...: runs a command of the engine.
marked() {
    SPHVAR_CLUSTER=$place "$@"
}

nothing_runs() {
    [ -z "$(processes)" ]
}

# Ends what is left of the engine and removes the folder, in any case.
clean() {
    local status=$?
    # A second signal must not leave processes or files.
    trap - EXIT
    trap '' INT TERM HUP
    cd /
    if [ "$status" != 0 ] && [ -d "$place/logs" ]; then
        tail -n 20 "$place"/logs/* || true
    fi
    local signal
    for signal in TERM KILL; do
        nothing_runs || kill -s "$signal" $(processes) 2>/dev/null || true
        within 10 nothing_runs && break
    done
    rm -rf "$place"
    exit "$status"
}

place=$(realpath "$(mktemp -d "${TMPDIR:-/tmp}/sphvar-cluster.XXXXXX")")
trap clean EXIT
trap 'exit 129' HUP
trap 'exit 130' INT
trap 'exit 143' TERM
mkdir "$place/logs"

# daemon NAME COMMAND...: starts a process of the engine; its id is then in the variable of that name.
daemon() {
    local name=$1
    shift
    (cd "$place" && SPHVAR_CLUSTER=$place exec "$@") >>"$place/logs/$name" 2>&1 &
    printf -v "$name" %s $!
    # Otherwise the shell reports that it was killed.
    disown
}

# alive ID: whether the process runs; one that has ended and was not waited for does not.
alive() {
    local state
    state=$(sed 's/.*) //; s/ .*//' "/proc/$1/stat" 2>/dev/null) && [ "$state" != Z ]
}

dead() {
    ! alive "$1"
}

# environment PACKAGES...: installs packages of Python for this script alone.
environment() {
    python3 -c 'import venv, ensurepip' 2>/dev/null ||
        unavailable "Python with the modules venv and pip is unavailable: apt-get install python3-venv"
    say "installing $* into a virtual environment"
    python3 -m venv "$place/python"
    "$place/python/bin/pip" install --quiet --disable-pip-version-check "$@" >"$place/logs/pip" 2>&1 || {
        tail -n 3 "$place/logs/pip"
        unavailable "pip cannot install $*"
    }
    python=$place/python/bin/python
}

# command_of_sphvar: sets SPHVAR, which the scripts of `sphvar plan` run.
command_of_sphvar() {
    if [ -z "${SPHVAR:-}" ]; then
        cargo build --release --package sphvar-cli
        SPHVAR=$target/release/sphvar
    fi
    SPHVAR=$(realpath -e "$SPHVAR")
    export SPHVAR
    say "$("$SPHVAR" --version): $SPHVAR"
}

# status KEY: a number of `plan status` of the job in the current folder.
status() {
    { "$SPHVAR" plan status job --json || true; } |
        python3 -c 'import json, sys; print(json.load(sys.stdin)[sys.argv[1]])' "$1"
}

some_are_done() {
    [ "$(status done)" -ge 2 ]
}

# Prints the ids of processes that compute parts, in random order.
running_parts() {
    local id
    for id in $(processes); do
        if grep -qzsx -e --shard "/proc/$id/cmdline"; then echo "$id"; fi
    done | sort -R
}

# catch: sets `caught` to the ids of the parts that run, at least one.
catch() {
    within 60 is_caught || fail "no part runs"
}

is_caught() {
    caught=$(running_parts)
    [ -n "$caught" ]
}

no_part_runs() {
    [ -z "$(running_parts)" ]
}

is_merged() {
    [ "$(status merged)" = True ]
}

# in_parts NAME KILL OUTPUT WORDS...: runs a command once and in parts, of which KILL ends some, and compares OUTPUT, the
# file or folder that both write.
in_parts() {
    local name=$1 kill=$2 output=$3 start one submitter line
    shift 3
    printf '\n== %s: sphvar %s\n' "$name" "$*"
    mkdir -p "$place/$name/one" "$place/$name/parts"
    cd "$place/$name/one"
    start=$EPOCHREALTIME
    # The words are those of the parts: figures show them.
    "$SPHVAR" "$@" >"$place/logs/$name-one" 2>&1
    one=$(seconds "$start")
    say "one run: $one s"

    cd "$place/$name/parts"
    "$SPHVAR" plan --shards "$parts" --for "$engine" -o job -- "$@"
    start=$EPOCHREALTIME
    marked submit job >"$place/logs/$name" 2>&1 &
    submitter=$!
    within 120 some_are_done || fail "$name: no part is done after 120 s"
    "$kill"
    wait "$submitter" || true
    settle
    if is_merged; then
        say "$engine has run the killed part again by itself"
    else
        "$SPHVAR" plan status job && fail "$name: the killed part is not missing"
        line=$("$SPHVAR" plan status job --resubmit || true)
        say "resubmit: $line"
        case $line in
        # All parts are done.
        */merge) $line >>"$place/logs/$name" 2>&1 ;;
        *) marked resubmit "$line" >>"$place/logs/$name" 2>&1 ;;
        esac
        within 120 is_merged || fail "$name: not merged after 120 s"
    fi
    say "$parts parts and their merge: $(seconds "$start") s; $("$python" "$tools/parts.py" starts job) starts of parts"
    "$SPHVAR" plan status job
    "$python" "$tools/parts.py" same "../one/$output" "$output" || fail "$name: the bytes differ from those of one run"
    pass "$name on $engine: bit-identical to one run after a kill"
    cd "$place"
}

# comparison KILL: predicted and measured variances of three patterns.
comparison() {
    in_parts comparison "$1" results compare white-noise,jittered,fibonacci -n 48,192,768 \
        --integrand cap:degrees=60 -m 40000 -o results
}

# catalogue KILL: the spectrum of 2^23 points, in 8 blocks.
catalogue() {
    say "generating a catalogue"
    "$SPHVAR" sample white-noise -n 8388608 -o "$place/catalogue.npy" --quiet
    in_parts catalogue "$1" spectrum.csv spectrum --points "$place/catalogue.npy" --lmax 512 -o spectrum.csv
}

# Sourced by the scripts beside it.

set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Every build here is complete; incremental builds and line tables would cost time and space.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_DEBUG=0

target=${CARGO_TARGET_DIR:-target}

fail() {
    echo "$1" >&2
    exit 1
}

# step NAME COMMAND...: runs a command and prints its time.
step() {
    local name=$1 start=$SECONDS
    shift
    printf '\n== %s\n' "$name"
    "$@"
    printf '== %s: %d s\n' "$name" $((SECONDS - start))
}

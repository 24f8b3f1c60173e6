#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# run_deps.sh RUN FOLDER: what `./run deps` does, with the system's commands replaced by ones that
# tell what was asked of them.
set -eu
run=$1
bin=$2/run_deps
mkdir -p "$bin"
log=$bin/log
failures=0

# stub NAME BODY…
stub() {
    name=$1
    shift
    printf '#!/bin/sh\n%s\n' "$*" >"$bin/$name"
    chmod +x "$bin/$name"
}

# expect WHAT EXIT CALLS OUTPUT: runs `./run deps test`; CALLS is all that was asked of apt-get,
# OUTPUT a pattern of standard output.
expect() {
    : >"$log"
    code=0
    output=$(PATH=$bin:$PATH "$run" deps test 2>"$bin/errors") || code=$?
    calls=$(cat "$log")
    matched=no
    # shellcheck disable=SC2254 # a pattern
    case $output in $4) matched=yes ;; esac
    if [ "$code" != "$2" ] || [ "$calls" != "$3" ] || [ $matched = no ]; then
        echo "$1: exit $code (expected $2), apt-get calls '$calls' (expected '$3'), output '$output' (expected $4)"
        cat "$bin/errors"
        failures=$((failures + 1))
    fi
}

# shellcheck disable=SC2016 # meant for the scripts
installed='shift 3; for p; do [ "$p" = "$MISSING" ] || echo "$p installed"; done'
stub dpkg-query "$installed"
stub apt-get "echo \"\$*\" >>'$log'"
stub id 'echo 1000'
stub sudo 'exit 1'

export MISSING=none
expect 'nothing missing' 0 '' ''
export MISSING=libcmocka-dev
expect 'no way to become root' 1 '' 'sudo apt-get install -y --no-install-recommends libcmocka-dev'
# shellcheck disable=SC2016
stub sudo '[ "$1" = -n ] && shift && exec "$@"'
expect 'by sudo' 0 'update -qq
install -y --no-install-recommends libcmocka-dev -qq' '*'
stub sudo 'exit 1'
stub id 'echo 0'
expect 'as root' 0 'update -qq
install -y --no-install-recommends libcmocka-dev -qq' '*'
# shellcheck disable=SC2016
stub dpkg-query 'shift 3; for p; do [ "$p" = python3 ] && echo "$p config-files" || echo "$p installed"; done'
expect 'removed, its configuration left' 0 'update -qq
install -y --no-install-recommends python3 -qq' '*'

[ $failures -eq 0 ]

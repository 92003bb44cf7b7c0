#!/usr/bin/env bash
# Sets up what ./run, ./test and .ci/run need: Debian packages, a configured build, the targets asked for.
# usage: tools/setup.sh [--no-install] [--packages FILE]... [--preset NAME] [--no-build] [TARGET...]
# Says what it does before it does it; does nothing where nothing is missing.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

install=yes build=yes preset=release targets=() lists=(tools/packages.txt)
while [ $# -gt 0 ]; do
  case $1 in
    --no-install) install=no ;;
    --no-build) build=no ;;
    --packages) lists+=("$2"); shift ;;
    --preset) preset=$2; shift ;;
    -*) echo "tools/setup.sh: unknown option $1" >&2; exit 64 ;;
    *) targets+=("$1") ;;
  esac
  shift
done

fail() { echo "setup: $1" >&2; exit "${2:-69}"; }

missing_packages() {
  command -v dpkg-query >/dev/null || fail "dpkg-query is missing; primo is set up on Debian 12. Elsewhere install what tools/packages.txt lists and use --no-install"
  local wanted installed
  wanted=$(sed -e 's/#.*//' "${lists[@]}" | awk 'NF {print $1}' | sort -u)
  # shellcheck disable=SC2086  # one word a package
  installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' $wanted 2>/dev/null | awk '$2 == "installed" {print $1}' | sort -u)
  comm -23 <(echo "$wanted") <(echo "$installed")
}

install_packages() {
  local missing sudo=()
  missing=$(missing_packages)
  [ -n "$missing" ] || return 0
  echo "setup: Debian packages to install:" $missing
  if [ "$install" = no ]; then
    echo "setup: --no-install: going on without them"
    return 0
  fi
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "installing needs root or sudo. As root: apt-get install$(printf ' %s' $missing)"
    sudo=(sudo)
  fi
  local log
  log=$(mktemp)
  if ! { "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update &&
         "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing; } >"$log" 2>&1; then
    tail -n 15 "$log" >&2
    rm -f "$log"
    fail "apt-get could not install the packages (its last lines are above). Is the package mirror reachable, and is this Debian 12?"
  fi
  rm -f "$log"
  echo "setup: packages installed ($(date -u -d "@$SECONDS" +%M:%S))"
}

# Compiling one of the larger files takes up to 1.5 GB.
jobs() {
  local cores memory
  cores=$(nproc)
  memory=$(awk '/^MemAvailable:/ {print int($2 / 1500000)}' /proc/meminfo)
  [ "$memory" -ge 1 ] || memory=1
  echo $((cores < memory ? cores : memory))
}

build() {
  local directory=build/$preset
  if [ ! -f "$directory/build.ninja" ]; then
    echo "setup: configuring $directory"
    cmake --preset "$preset" >"/tmp/primo_configure.$$" 2>&1 || {
      tail -n 30 "/tmp/primo_configure.$$" >&2
      rm -f "/tmp/primo_configure.$$"
      fail "cmake could not configure $directory (its last lines are above)" 1
    }
    rm -f "/tmp/primo_configure.$$"
  fi
  # Silent when nothing is to be done.
  if [ "$(ninja -C "$directory" -n "${targets[@]}" | tail -n 1)" = "ninja: no work to do." ]; then return 0; fi
  echo "setup: building $directory with $(jobs) jobs${targets[*]:+: ${targets[*]}}"
  NINJA_STATUS='[%f/%t %es] ' ninja -C "$directory" -j "$(jobs)" "${targets[@]}" || fail "the build failed (the compiler's messages are above)" 1
  echo "setup: built ($(date -u -d "@$SECONDS" +%M:%S))"
}

install_packages
if [ "$build" = yes ]; then build; fi

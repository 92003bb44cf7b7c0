#!/usr/bin/env bash
# clang-tidy over the project's own sources, several at a time. A file whose preprocessed neighbourhood (its own text, every header of the
# project, the checks) has passed before is skipped.
# usage: tools/tidy.sh [--build DIR] [FILE...]      without files: libraries, services and tools
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=build/release
if [ "${1:-}" = --build ]; then build=$2; shift 2; fi
[ -f "$build/compile_commands.json" ] || { echo "tidy: $build is not configured; run tools/setup.sh first" >&2; exit 69; }
files=("$@")
if [ ${#files[@]} -eq 0 ]; then
  mapfile -t files < <(git ls-files 'libs/*.cpp' 'services/*.cpp' 'tools/*.cpp')
fi
stamps=$build/tidy
mkdir -p "$stamps"
common=$({ cat .clang-tidy; git ls-files '*.h' '*.idl' | xargs -r cat; } | sha256sum | cut -c1-16)
export build stamps common

check_one() {
  local file=$1 stamp
  grep -qF "/$file\"" "$build/compile_commands.json" || return 0  # not part of this build, e.g. a fuzzer
  stamp=$stamps/$(cat "$file" <(echo "$file $common") | sha256sum | cut -c1-32)
  [ -e "$stamp" ] && return 0
  local output
  local status=0
  output=$(clang-tidy -p "$build" --quiet "$file" 2>/dev/null) || status=1
  [ -z "$output" ] || printf '%s\n' "$output"
  if [ $status -eq 0 ]; then touch "$stamp"; fi
  return $status
}
export -f check_one
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" bash -c 'check_one "$0"'

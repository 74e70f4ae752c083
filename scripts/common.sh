# Sourced by scripts/test and scripts/demo: one way to set up, to configure, and to say what failed.
# shellcheck shell=bash
set -euo pipefail

program="scripts/$(basename "$0")"
source_root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$source_root"
# Debian's own tools come before any that the user has put first (a Python of their own, say).
export PATH="/usr/sbin:/usr/bin:/sbin:/bin:$PATH"
# A clone that belongs to someone else (a mounted folder, a container) is still read.
export GIT_CONFIG_COUNT=1 GIT_CONFIG_KEY_0=safe.directory GIT_CONFIG_VALUE_0="$source_root"

current_step="start"
begin_step() {
  current_step="$1"
  printf '== %s\n' "$1"
}

# Runs at exit, set by the caller with: trap 'report_failure $?' EXIT
report_failure() {
  if [ "$1" -ne 0 ]; then echo "$program: failed at: $current_step (exit status $1)" >&2; fi
}

# configure PRESET: only when there is something new to configure. Ninja itself notices changed
# CMakeLists.txt files; it does not notice new ones, a changed preset, or a moved checkout.
configure() {
  local preset="$1" build_dir="build/$1" key
  key="$(
    { echo "$source_root" && cat CMakePresets.json && ls ./*/CMakeLists.txt tests/*/CMakeLists.txt; } |
      sha256sum
  )"
  if [ -f "$build_dir/build.ninja" ] && [ "$(cat "$build_dir/configured" 2>/dev/null)" = "$key" ]; then
    return
  fi
  local fresh=()
  if [ -f "$build_dir/CMakeCache.txt" ] &&
    ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$source_root" "$build_dir/CMakeCache.txt"; then
    fresh=(--fresh)
  fi
  cmake --log-level=NOTICE --preset "$preset" "${fresh[@]}"
  echo "$key" >"$build_dir/configured"
}

#!/usr/bin/env bash
# The QP against public solvers: fetches those that the Python package index offers with C or C++ sources or libraries,
# builds them and ours under build/, and prints a table for each set of corridors. What cannot be had is skipped and named.
#   tests/bench/qp/run.sh [--quick] [--only NAME]     SWIFTLET_SHARED: folder with cases/cases.jsonl (default ../shared)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
peers=$PWD/build/qp_peers
archives=$peers/archives
mkdir -p "$archives"

# get NAME REQUIREMENT KIND: unpacks the package into build/qp_peers/NAME. KIND is sdist or wheel.
get() {
  if [[ -d $peers/$1 ]]; then return; fi
  local kind=(--only-binary :all:)
  if [[ $3 == sdist ]]; then kind=(--no-binary "${2%%=*}"); fi
  local folder=$archives/$1
  if ! "$peers/venv/bin/pip" download -q --no-deps "${kind[@]}" -d "$folder" "$2" >"$archives/$1.log" 2>&1; then
    echo "$1 is left out: the package index did not give $2 ($archives/$1.log)" >&2
    return
  fi
  mkdir "$peers/$1"
  if [[ $3 == sdist ]]; then
    tar -xzf "$folder"/*.tar.gz -C "$peers/$1" --strip-components=1
  else
    python3 -m zipfile -e "$folder"/*.whl "$peers/$1"
  fi
}

if [[ ! -x $peers/venv/bin/pip ]]; then python3 -m venv "$peers/venv"; fi
get daqp daqp==0.11.0 sdist
get quadprog quadprog==0.1.14 sdist
get piqp piqp==0.7.0 sdist
get osqp osqp==0.6.7.post3 sdist # the last one that brings its C sources
get eiquadprog eiquadprog==1.3.2 wheel
get qpoases cmeel-qpoases==3.2.2 wheel

cmake -S tests/bench/qp -B build/qp_bench -G Ninja -DPEERS="$peers" >build/qp_bench.log
cmake --build build/qp_bench -j "$(nproc)" >>build/qp_bench.log
exec taskset -c 0 build/qp_bench/qp_bench --cases "${SWIFTLET_SHARED:-../shared}/cases/cases.jsonl" "$@"

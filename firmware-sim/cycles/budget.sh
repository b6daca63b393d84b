#!/usr/bin/env bash
# Traces models of many sizes (examples/budget_sizes.rs): what the costs of `ballrace budget` are fitted to, and what its
# predictions are checked against on other sizes.
#
#   budget.sh DIR     # afterwards: cargo run --release -p ballrace --example budget_costs -- fit|check DIR
#
# DIR keeps each trace; one that is there is not made again. Some 5 minutes on one core.
set -euo pipefail

directory=$(realpath -m "${1:?usage: budget.sh DIR}")
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$directory"
cd "$here/.."
cargo run --quiet --release --locked --example budget_sizes -- "$directory"
for model in "$directory"/fit/*.bin "$directory"/check/*.bin; do
    for functions in exact approx; do
        trace=${model%.bin}.$functions.json
        [[ ! -s $trace ]] || continue
        arguments=()
        [[ $functions == exact ]] || arguments=(approx)
        ./cycles.sh "$model" "$directory/samples.f32" "${arguments[@]}" --wait-states 5 --flash cached --json >"$trace.part"
        mv "$trace.part" "$trace"
        echo "$trace"
    done
done

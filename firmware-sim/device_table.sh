#!/usr/bin/env bash
# Everything the device costs, as tables: builds and runs the image of models of the paper's sizes on every emulated board, holds
# each to the host's bits, traces cycles by stage, and measures the networks beside others' (peers.sh).
#
#   device_table.sh [DIR]     # DIR keeps models and samples; by default a folder of the target folder. Some 5 minutes
#
# Needs what compare.sh, cycles.sh and peers.sh need.
set -euo pipefail

fail() {
    echo "device_table.sh: $*" >&2
    exit 1
}

here=$(cd "$(dirname "$0")" && pwd)
CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
export CARGO_TARGET_DIR
directory=$(realpath -m "${1:-$CARGO_TARGET_DIR/device_table}")
mkdir -p "$directory"
cd "$here"
cargo run --quiet --release --locked --example paper_sizes -- "$directory"
samples=$directory/samples.f32

# number PATTERN TEXT is the number behind a pattern.
number() {
    sed -nE "s/.*$1([0-9]+).*/\1/p" <<<"$2" | head -n 1
}

echo "Boards: 8-256-8 in f32, 2 harmonics, exact functions; instructions a sample"
echo
echo "| board | target | mean | worst | code, bytes | model, bytes | RAM, bytes | CRC |"
echo "|---|---|---|---|---|---|---|---|"
for board in image/boards/*/; do
    board=$(basename "$board")
    run=$(./compare.sh "$directory/half.bin" "$samples" --board "$board") || fail "$board: $run"
    echo "| \`$board\` | \`$(<"image/boards/$board/target")\` | $(number '"instructions_per_sample":' "$run") |" \
        "$(number '"instructions_worst":' "$run") | $(number 'model, ' "$run") | $(number 'bytes \(' "$run") |" \
        "$(number 'RAM: ' "$run") | $(sed -nE 's/.*crc ([0-9a-f]{8}).*/\1/p' <<<"$run" | head -n 1) |"
done

stages=(screen states encoder activation library xi decoder monitor other total)
echo
echo "Cycles of an evaluated sample on the Cortex-M4F by stage, without wait states; of the worst; mean of all with the 5 of an STM32F4;"
echo "instructions, mean of all"
echo
echo "| model | functions |$(printf ' %s |' "${stages[@]}") worst | 5 wait states | instructions |"
echo "|---|---|$(printf -- '---|%.0s' "${stages[@]}")---|---|---|"
for point in half: half:approx float_24: fixed_64: fixed_32: fixed_24: fixed_16:; do
    model=${point%%:*} functions=${point#*:}
    run=$(./cycles.sh "$directory/$model.bin" "$samples" ${functions:+"$functions"} --wait-states 5) || fail "$model: $run"
    row="| $model | ${functions:-exact} |"
    for stage in "${stages[@]}"; do
        row+=" $(awk -v stage="$stage" '$1 == stage { print $4 }' <<<"$run") |"
    done
    echo "$row $(awk '$1 == "total" { print $5 }' <<<"$run") | $(awk '$1 == "total" { print $8 }' <<<"$run") | $(awk '$1 == "total" { print $2 }' <<<"$run") |"
done
echo
./peers.sh

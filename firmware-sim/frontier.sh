#!/usr/bin/env bash
# Score against cycles, flash and RAM, from single precision of the paper's size to the smallest: fits a model of each size to a
# run to failure, and prints the table of `ballrace budget` with each model's first alarm; the picture goes to OUT/frontier.svg.
#
#   frontier.sh RECORDINGS OUT     # RECORDINGS: a folder of FEMTO, say. OUT keeps the models; some four minutes on two cores
set -euo pipefail

[[ $# -eq 2 && -d $1 ]] || { echo "usage: frontier.sh RECORDINGS OUT" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
recordings=$(realpath "$1")
mkdir -p "$2"
out=$(realpath "$2")
cd "$here/.."
cargo build --quiet --release --locked -p ballrace
ballrace=$(realpath -m "${CARGO_TARGET_DIR:-target}")/release/ballrace

# fit NAME OPTION… fits a model that is not there yet.
fit() {
    [[ -s $out/$1.json ]] || "$ballrace" fit "$recordings" --out "$out/$1.json" --null 0 --trainings 1 "${@:2}" >/dev/null 2>&1 ||
        { echo "frontier.sh: $1 cannot be fitted; see $ballrace fit $recordings ${*:2}" >&2; exit 1; }
    models+=("$out/$1.json")
}

models=()
# Fewer units learn slowly, and their steps cost little.
long=(--max-steps 50000)
fit f32_256
fit f32_64 --hidden 64 "${long[@]}"
fit f32_24 --hidden 24 "${long[@]}"
for units in 64 32 24 16 8; do
    fit "fixed_$units" --hidden "$units" --arithmetic fixed "${long[@]}"
done
fit least_squares --solver stlsq
"$ballrace" budget --model "${models[@]}" --plot "$out/frontier.svg"
for model in "${models[@]}"; do
    alarm=$("$ballrace" monitor --model "$model" "$recordings" 2>&1 >/dev/null | grep -E '^(first alarm|no alarm)')
    echo "$(basename "$model" .json): $alarm"
done

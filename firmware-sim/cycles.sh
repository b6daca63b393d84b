#!/usr/bin/env bash
# Traces every instruction that an image executes for its samples on an emulated Cortex-M4F, and prints instructions and
# estimated cycles a sample by stage.
#
#   cycles.sh MODEL.bin SAMPLES.f32 [approx] [--wait-states N] [--flash plain|prefetch|cached] [--json]
#   cycles.sh --kernel SYMBOL ELF [...]     # cycles of one function of any image for the board
#
# Without `--wait-states` code and constants are read at once. Needs what compare.sh needs.
# Something to try it with: cargo run -p ballrace-firmware-sim --example paper_sizes -- DIR
set -euo pipefail

fail() {
    echo "cycles.sh: $*" >&2
    exit "${code:-1}"
}

usage="usage: cycles.sh MODEL.bin SAMPLES.f32 [approx] [--wait-states N] [--flash plain|prefetch|cached] [--json], or --kernel SYMBOL ELF"
files=() features=() plugin="" kernel="" json=""
while [[ $# -gt 0 ]]; do
    case $1 in
        approx) features=(--features approx) ;;
        --json) json=1 plugin+=",json=on" ;;
        --wait-states) plugin+=",waits=${2-}"; shift ;;
        --flash) plugin+=",flash=${2-}"; shift ;;
        --kernel) kernel=${2-}; shift ;;
        -h | --help) echo "$usage"; exit 0 ;;
        -*) code=2 fail "$usage" ;;
        *) files+=("$1") ;;
    esac
    shift || { code=2; fail "$usage"; }
done
expected=2
[[ -z $kernel ]] || expected=1
[[ ${#files[@]} -eq $expected ]] || code=2 fail "$usage"
for file in "${files[@]}"; do
    [[ -f $file ]] || code=2 fail "$file: not a file"
done
here=$(cd "$(dirname "$0")" && pwd)
CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
export CARGO_TARGET_DIR

cargo build --quiet --release --locked --manifest-path "$here/cycles/Cargo.toml" || fail "the plugin does not build"
if [[ -n $kernel ]]; then
    elf=$(realpath "${files[0]}")
    address=$(nm "$elf" | awk -v name="$kernel" '$3 == name { print $1 }')
    [[ -n $address ]] || code=2 fail "$elf: no symbol $kernel"
    plugin+=",kernel=$address"
else
    BALLRACE_MODEL=$(realpath "${files[0]}")
    BALLRACE_SAMPLES=$(realpath "${files[1]}")
    export BALLRACE_MODEL BALLRACE_SAMPLES
    # In the image's folder, whose cargo configuration names the target.
    (cd "$here/image" && cargo build --quiet --release --locked --bins "${features[@]}") ||
        fail "the image does not build"
    elf=$CARGO_TARGET_DIR/thumbv7em-none-eabihf/release/report
fi
out=$(mktemp)
trap 'rm -f "$out"' EXIT
run=$("$here/image/qemu.sh" "$elf" -plugin "$CARGO_TARGET_DIR/release/libballrace_cycles.so,elf=$elf,out=$out$plugin") ||
    fail "the image failed (exit $?, 124 is out of time): ${run:-no output}"
[[ -s $out ]] || fail "the plugin wrote nothing"
if [[ -n $kernel ]]; then
    cat "$out"
elif [[ -z $json ]]; then
    cat "$out"
    # The board's timer counts the same instructions, to one reading of it.
    echo "the image's own counter: $(grep -o '"instructions_per_sample":[0-9]*,"instructions_worst":[0-9]*' <<<"$run" || echo none)"
else
    # With what the image reports itself, and the memory of the image that holds nothing but the device.
    read -r text data bss _ < <(size "${elf%report}device" | tail -n 1)
    flash=$((text + data - $(stat -c %s "$BALLRACE_SAMPLES")))
    traced=$(<"$out")
    echo "{\"image\":$run,\"flash_bytes\":$flash,\"static_bytes\":$((data + bss)),${traced#\{}"
fi

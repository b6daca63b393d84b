#!/usr/bin/env bash
# Holds device and host to the same bits: runs a model over samples on an emulated board and on the host, and compares
# a CRC over every intermediate number. Says what the device costs, and fails where its code could panic.
#
#   compare.sh MODEL.bin SAMPLES.f32 [approx] [--board NAME]
#
# With `approx` both are built with the faster functions of ballrace_core::math. NAME is a folder of image/boards,
# without it BALLRACE_BOARD, without that mps2_an386.
# Something to try it with: cargo run -p ballrace-firmware-sim --example paper_sizes -- DIR
set -euo pipefail

fail() {
    echo "compare.sh: $*" >&2
    exit 1
}

refuse() {
    echo "compare.sh: $*" >&2
    echo "usage: compare.sh MODEL.bin SAMPLES.f32 [approx] [--board NAME]" >&2
    exit 2
}

features=()
files=()
board=${BALLRACE_BOARD:-mps2_an386}
while [[ $# -gt 0 ]]; do
    case $1 in
        approx) features=(--features approx) ;;
        --board) [[ $# -gt 1 ]] || refuse "--board: found nothing after it, expected a board"; board=$2; shift ;;
        -*) refuse "$1: no such option" ;;
        *) files+=("$1") ;;
    esac
    shift
done
[[ ${#files[@]} -eq 2 ]] || refuse "found ${#files[@]} files, expected a model and samples"
for file in "${files[@]}"; do
    [[ -f $file ]] || refuse "$file: not a file"
done
here=$(cd "$(dirname "$0")" && pwd)
[[ -f $here/image/boards/$board/target ]] ||
    refuse "--board: found $board, expected one of $(cd "$here/image/boards" && echo *)"
target=$(<"$here/image/boards/$board/target")
BALLRACE_MODEL=$(realpath "${files[0]}")
BALLRACE_SAMPLES=$(realpath "${files[1]}")
BALLRACE_BOARD=$board
# One place for both builds; absolute, since each is started in its own folder.
CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
export BALLRACE_MODEL BALLRACE_SAMPLES BALLRACE_BOARD CARGO_TARGET_DIR
images=$CARGO_TARGET_DIR/$target/release

# In the image's folder, whose cargo configuration names the emulator.
cd "$here/image"
cargo build --quiet --release --locked --bins --target "$target" "${features[@]}" || fail "the image does not build"
device=$(./qemu.sh "$images/report") || fail "the image failed (exit $?, 124 is out of time): ${device:-no output}"
cd "$here"
host=$(cargo run --quiet --release --bin ballrace-firmware-sim "${features[@]}" -- \
    --model "$BALLRACE_MODEL" --samples "$BALLRACE_SAMPLES") || fail "the host's run failed"

echo "host    $host"
echo "device  $device"
# The device's line is the host's, with more keys before the last brace.
[[ $device == "${host%\}}",* ]] || fail "device and host differ"
[[ $host != *'"evaluated":0,'* ]] || fail "no sample was evaluated, so nothing was compared"
crc=${host#*\"crc\":\"}
echo "$board and host agree: crc ${crc%%\"*}"

# Of the image that holds nothing but the device.
read -r text data _ < <(size "$images/device" | tail -n 1)
# By name, since riscv-rt has a section of all of the stack's memory.
bss=$(size -A "$images/device" | awk '$1 ~ /^\.(bss|uninit)$/ { sum += $2 } END { print sum + 0 }')
model=$(stat -c %s "$BALLRACE_MODEL")
samples=$(stat -c %s "$BALLRACE_SAMPLES")
stack=${device#*\"stack_bytes\":}
echo "flash: $((text + data - samples)) bytes ($model model, $((text + data - samples - model)) code and constants)"
echo "RAM: $((data + bss + ${stack%\}})) bytes ($((data + bss)) static, ${stack%\}} stack)"

panics=$(nm "$images/device" | grep -c 'core.*panicking' || true)
[[ $panics -eq 0 ]] || fail "the device can panic: $panics functions of core::panicking are linked; " \
    "find their callers with llvm-objdump -d $images/device"
echo "no panic is reachable from the device's code"

#!/usr/bin/env bash
# Holds device and host to the same bits: runs a model over samples on an emulated Cortex-M4F and on
# the host, and compares a CRC over every intermediate number. Says what the device costs, and fails
# where its code could panic.
#
#   compare.sh MODEL.bin SAMPLES.f32 [approx]
#
# With `approx` both are built with the faster functions of ballrace_core::math.
# Something to try it with: cargo run -p ballrace-firmware-sim --example paper_sizes -- DIR
set -euo pipefail

fail() {
    echo "compare.sh: $*" >&2
    exit 1
}

usage="usage: compare.sh MODEL.bin SAMPLES.f32 [approx]"
[[ $# -eq 2 || ($# -eq 3 && $3 == approx) ]] || { echo "$usage" >&2; exit 2; }
features=()
[[ $# -eq 2 ]] || features=(--features approx)
for file in "$1" "$2"; do
    [[ -f $file ]] || { echo "compare.sh: $file: not a file" >&2; exit 2; }
done
here=$(cd "$(dirname "$0")" && pwd)
BALLRACE_MODEL=$(realpath "$1")
BALLRACE_SAMPLES=$(realpath "$2")
# One place for both builds; absolute, since each is started in its own folder.
CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
export BALLRACE_MODEL BALLRACE_SAMPLES CARGO_TARGET_DIR
images=$CARGO_TARGET_DIR/thumbv7em-none-eabihf/release

# In the image's folder, whose cargo configuration names the target and the emulator.
cd "$here/image"
cargo build --quiet --release --locked --bins "${features[@]}" || fail "the image does not build"
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
echo "device and host agree: crc ${crc%%\"*}"

# Of the image that holds nothing but the device.
read -r text data bss _ < <(size "$images/device" | tail -n 1)
model=$(stat -c %s "$BALLRACE_MODEL")
samples=$(stat -c %s "$BALLRACE_SAMPLES")
stack=${device#*\"stack_bytes\":}
echo "flash: $((text + data - samples)) bytes ($model model, $((text + data - samples - model)) code and constants)"
echo "RAM: $((data + bss + ${stack%\}})) bytes ($((data + bss)) static, ${stack%\}} stack)"

panics=$(nm "$images/device" | grep -c 'core.*panicking' || true)
[[ $panics -eq 0 ]] || fail "the device can panic: $panics functions of core::panicking are linked; " \
    "find their callers with llvm-objdump -d $images/device"
echo "no panic is reachable from the device's code"

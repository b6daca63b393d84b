#!/usr/bin/env bash
# Holds C and Rust to the same bits: builds libballrace.a and the C program of example/, natively and for an emulated
# Cortex-M4F, runs both over a model and samples, and compares their report, a CRC over every intermediate number in it,
# with that of the Rust program of the host. Fails where a panic is reachable from what the C program calls.
#
#   compare.sh MODEL.bin SAMPLES.f32
#
# Needs gcc, arm-none-eabi-gcc, qemu-system-arm, the target thumbv7em-none-eabihf.
set -euo pipefail

fail() {
    echo "compare.sh: $*" >&2
    exit 1
}

[[ $# -eq 2 && -f $1 && -f $2 ]] || { echo "usage: compare.sh MODEL.bin SAMPLES.f32" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
model=$(realpath "$1")
samples=$(realpath "$2")
board=mps2_an386
target=$(<"$here/../image/boards/$board/target")
CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-$here/../../target}")
export CARGO_TARGET_DIR
out=$CARGO_TARGET_DIR/c-example
mkdir -p "$out"
cd "$here"

cargo build --quiet --release --locked
cargo build --quiet --release --locked --target "$target"
flags=(-std=c11 -O2 -Wall -Wextra -Werror -Iinclude "-DMODEL=\"$model\"" "-DSAMPLES=\"$samples\"")
gcc "${flags[@]}" example/main.c example/platform_host.c example/embedded.S \
    "$CARGO_TARGET_DIR/release/libballrace.a" -lm -o "$out/native"
arm-none-eabi-gcc "${flags[@]}" -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -ffunction-sections \
    -nostartfiles -Wl,--gc-sections,-z,noexecstack -T "example/$board.ld" \
    example/main.c "example/platform_$board.c" example/embedded.S \
    "$CARGO_TARGET_DIR/$target/release/libballrace.a" -o "$out/$board"

native=$("$out/native") || fail "the native program failed: ${native:-no output}"
device=$(BALLRACE_BOARD=$board ../image/qemu.sh "$out/$board") ||
    fail "the board's program failed (exit $?, 124 is out of time): ${device:-no output}"
cd ..
rust=$(cargo run --quiet --release --bin ballrace-firmware-sim -- --model "$model" --samples "$samples") ||
    fail "the Rust program failed"

echo "Rust    $rust"
echo "C       $native"
echo "device  $device"
[[ $native == "$rust" ]] || fail "C and Rust differ"
[[ $device == "$rust" ]] || fail "C on $board and Rust differ"
[[ $rust != *'"evaluated":0,'* ]] || fail "no sample was evaluated, so nothing was compared"
panics=$(nm "$out/$board" | grep -c 'core.*panicking' || true)
[[ $panics -eq 0 ]] || fail "the library can panic: $panics functions of core::panicking are linked"
echo "C on the host and on $board agrees with Rust, and no panic is reachable"

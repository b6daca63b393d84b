#!/usr/bin/env bash
# A network of ballrace-core beside those of others, in the same emulator with the same counter: instructions and estimated
# cycles of one pass, flash, static RAM, stack, and the error against double precision, as a table.
#
#   peers.sh [HIDDEN…]     # units of the hidden layer, 256 and 24 without; 8 inputs, sigmoid, 8 outputs
#
# Beside: CMSIS-NN (from $BALLRACE_PEERS/cmsis-nn, by default ../shared/peers beside this repository; left out where it is
# not there), emlearn (from PyPI, into a Python environment in the target folder), nalgebra, burn. Needs arm-none-eabi-gcc,
# qemu-system-arm, the target thumbv7em-none-eabihf, python3. Everybody is compiled with -O3 and the FPU on.
set -euo pipefail

fail() {
    echo "peers.sh: $*" >&2
    exit 1
}

here=$(cd "$(dirname "$0")" && pwd)
hidden=("$@")
[[ ${#hidden[@]} -gt 0 ]] || hidden=(256 24)
for units in "${hidden[@]}"; do
    [[ $units =~ ^[0-9]+$ ]] || { echo "usage: peers.sh [HIDDEN…]" >&2; exit 2; }
done
CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}")
export CARGO_TARGET_DIR
cmsis=$(realpath -m "${BALLRACE_PEERS:-$here/../../shared/peers}")/cmsis-nn
target=$(<"$here/image/boards/mps2_an386/target")
out=$CARGO_TARGET_DIR/peers
mkdir -p "$out"
cd "$here"

cargo build --quiet --release --locked --example peer_networks
examples=$CARGO_TARGET_DIR/release/examples
if [[ ! -x $out/python/bin/python ]]; then
    python3 -m venv "$out/python"
    "$out/python/bin/pip" install --quiet emlearn==0.23.2 || { rm -rf "$out/python"; fail "emlearn cannot be installed"; }
fi
emlearn=$("$out/python/bin/python" -c 'import emlearn; print(emlearn.includedir)')

# image NAME FILE… builds the harness with a peer; flags of its own in `peer_flags`.
peer_flags=()
image() {
    arm-none-eabi-gcc -std=gnu11 -O3 -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -ffunction-sections \
        -fdata-sections -nostartfiles -Wl,--gc-sections,-z,noexecstack -T c-api/example/mps2_an386.ld \
        -Ipeers -Ic-api/example "-I$network" "${peer_flags[@]}" \
        peers/harness.c c-api/example/platform_mps2_an386.c "${@:2}" -lm -o "$network/$1"
}

# row NAME LABEL measures an image.
row() {
    local output text data bss stack error instructions cycles
    output=$network/$1.txt
    image/qemu.sh "$network/$1" >"$output" || fail "$1 failed: $(<"$output")"
    stack=$((16#$(awk '/^stack/ { print $2 }' "$output")))
    error=$("$examples/peer_networks" check "$network" "$output")
    read -r _ instructions cycles _ < <(./cycles.sh --kernel kernel "$network/$1" | grep ^total)
    read -r text data bss _ < <(size "$network/$1" | tail -n 1)
    echo "| $units | $2 | $instructions | $cycles | $((text + data - base_flash)) | $((data + bss - base_ram)) | $stack | $error |"
}

# rust NAME FEATURES LABEL builds the library with a kernel in Rust, and measures it.
rust() {
    RUSTFLAGS="-C target-cpu=cortex-m4" BALLRACE_NETWORK=$network \
        cargo build --quiet --release --locked --manifest-path peers/rust/Cargo.toml --target "$target" --features "$2"
    image "$1" "$CARGO_TARGET_DIR/$target/release/libballrace_peers.a"
    row "$1" "$3"
}

echo "| hidden | network | instructions | cycles | flash, bytes | static RAM, bytes | stack, bytes | error |"
echo "|---|---|---|---|---|---|---|---|"
for units in "${hidden[@]}"; do
    network=$out/$units
    "$examples/peer_networks" write "$network" "$units"
    peer_flags=()
    image none peers/none.c
    read -r text data bss _ < <(size "$network/none" | tail -n 1)
    base_flash=$((text + data)) base_ram=$((data + bss))
    rust float float "ballrace, f32"
    rust approx float,approx "ballrace, f32, \`approx\`"
    rust fixed fixed "ballrace, 16-bit fixed point"
    rust nalgebra nalgebra "nalgebra, f32, \`libm\`"
    rust burn burn "burn, f32, backend \`flex\`"
    "$out/python/bin/python" peers/emlearn_network.py "$network/weights.txt" "$network/emlearn_network.h"
    peer_flags=("-I$emlearn")
    image emlearn peers/emlearn.c
    row emlearn "emlearn, f32"
    if [[ -d $cmsis ]]; then
        mapfile -t sources < <(find "$cmsis/Source" -name '*.c')
        peer_flags=("-I$cmsis/Include")
        image cmsis_s8 peers/cmsis_s8.c "${sources[@]}"
        row cmsis_s8 "CMSIS-NN, 8-bit"
        image cmsis_s16 peers/cmsis_s16.c "${sources[@]}"
        row cmsis_s16 "CMSIS-NN, 16-bit, weights 8-bit"
    else
        echo "peers.sh: no CMSIS-NN in $cmsis" >&2
    fi
done

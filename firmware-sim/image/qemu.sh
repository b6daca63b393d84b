#!/usr/bin/env bash
# Runs an image on the emulated board that BALLRACE_BOARD names: qemu.sh ELF [OPTION OF QEMU…]. The exit code is the image's.
set -euo pipefail
# A fixed time for each instruction makes the board's timer count instructions. An image that hangs
# is ended after BALLRACE_QEMU_SECONDS, and no input, since QEMU would take the terminal's.
board=$(cd "$(dirname "$0")" && pwd)/boards/${BALLRACE_BOARD:-mps2_an386}
read -ra machine <"$board/qemu.args"
exec timeout "${BALLRACE_QEMU_SECONDS:-300}" "$(<"$board/emulator")" \
    "${machine[@]}" -icount shift=10 \
    -display none -monitor none -serial none \
    -semihosting-config enable=on,target=native \
    -kernel "${1:?usage: qemu.sh ELF [OPTION OF QEMU…]}" "${@:2}" </dev/null

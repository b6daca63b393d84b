/* One pass of a network over each input on a Cortex-M4F without an operating system: prints every output, and the stack that
 * a pass takes. A peer is a file with prepare() and kernel(). */
#include <stdint.h>
#include <string.h>

#include "network.h"
#include "peer.h"
#include "platform.h"

extern uint32_t bss_end[];

enum { PAINT = 0x5a };

static void hexadecimal(char *to, uint32_t word)
{
    for (int digit = 7; digit >= 0; digit--, word >>= 4)
        to[digit] = "0123456789abcdef"[word & 15];
}

/* Bytes of stack below `top` that are no longer painted. */
static unsigned used(const volatile uint8_t *bottom, const volatile uint8_t *top)
{
    while (bottom < top && *bottom == PAINT)
        bottom++;
    return (unsigned)(top - bottom);
}

int main(void)
{
    static float y[OUTPUTS];
    static char line[9 * OUTPUTS + 1], report[] = "stack 00000000";
    uint8_t here;
    volatile uint8_t *top = &here - 64, *bottom = top - 16384;
    prepare();
    for (volatile uint8_t *at = bottom; at < top; at++)
        *at = PAINT;
    for (int i = 0; i < INPUT_ROWS; i++)
        kernel(network_inputs[i], y);
    hexadecimal(report + 6, used(bottom, top));
    say(report);
    for (int i = 0; i < INPUT_ROWS; i++) {
        kernel(network_inputs[i], y);
        for (int o = 0; o < OUTPUTS; o++) {
            uint32_t word;
            memcpy(&word, &y[o], 4);
            hexadecimal(line + 9 * o, word);
            line[9 * o + 8] = ' ';
        }
        say(line);
    }
    leave(0);
}

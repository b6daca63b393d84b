/* The example on a Cortex-M4F without an operating system: vectors, start-up, and semihosting for its output. */
#include <stdint.h>
#include <string.h>

#include "platform.h"

/* Of mps2_an386.ld. */
extern uint32_t data_start[], data_end[], data_load[], bss_start[], bss_end[], stack_top[];

int main(void);

enum { SYS_OPEN = 0x01, SYS_WRITE = 0x05, OPEN_WRITE = 4, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

static uintptr_t semihost(uintptr_t operation, const void *argument)
{
    register uintptr_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void say(const char *line)
{
    /* The console. */
    static const char console[] = ":tt";
    const uintptr_t open[3] = {(uintptr_t)console, OPEN_WRITE, sizeof console - 1};
    const uintptr_t file = semihost(SYS_OPEN, open);
    const uintptr_t text[3] = {file, (uintptr_t)line, strlen(line)}, end[3] = {file, (uintptr_t)"\n", 1};
    semihost(SYS_WRITE, text);
    semihost(SYS_WRITE, end);
}

_Noreturn void leave(int code)
{
    const uint32_t reason[2] = {APPLICATION_EXIT, (uint32_t)code};
    for (;;)
        semihost(SYS_EXIT_EXTENDED, reason);
}

static void fault(void)
{
    say("fault");
    leave(1);
}

void reset(void)
{
    /* Coprocessors 10 and 11: the floating-point unit. */
    *(volatile uint32_t *)0xe000ed88 |= UINT32_C(0xf) << 20;
    __asm__ volatile("dsb\n isb" ::: "memory");
    const uint32_t *from = data_load;
    for (uint32_t *to = data_start; to < data_end; to++)
        *to = *from++;
    for (uint32_t *to = bss_start; to < bss_end; to++)
        *to = 0;
    main();
    leave(1);
}

/* Stack, reset, and every fault. */
__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};

/* The example as a program of the host. */
#include <stdio.h>
#include <stdlib.h>

#include "platform.h"

void say(const char *line)
{
    puts(line);
}

_Noreturn void leave(int code)
{
    exit(code);
}

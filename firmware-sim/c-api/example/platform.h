/* What the example needs of its platform: a line of text, and an end. */
#ifndef PLATFORM_H
#define PLATFORM_H

void say(const char *line);
_Noreturn void leave(int code);

#endif

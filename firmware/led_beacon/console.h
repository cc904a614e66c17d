// What the host says on the serial line and what it is answered. README.md lists the commands.
#pragma once

// Play what is kept.
void console_begin(void);

// Do what came on the line and what the light asks for.
void console_poll(void);

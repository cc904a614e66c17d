// Commands of the host, listed in README.md.
#pragma once

// Execute a line without its end, whose checksum is removed, and send the reply. A line that is not exactly a command has no effect.
void commands_execute(char *line);

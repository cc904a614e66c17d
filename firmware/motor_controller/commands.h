// What the host may order. README.md lists it.
#pragma once

// Obey a line without its end, and answer it. One that is not a command, to the letter, changes nothing.
void commands_obey(const char *line);

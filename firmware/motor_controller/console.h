// Collects lines from the serial port and has them obeyed.
#pragma once

// Obey the next line if it is there and the last answer is on its way. Never waits.
void console_poll(void);

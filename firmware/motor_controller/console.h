// Collects lines from the serial port and executes them.
#pragma once

// Execute the next line if it is complete and the last reply has been sent. Never blocks.
void console_poll(void);

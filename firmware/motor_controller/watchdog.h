// Resets the controller, and with it the motors, when the main loop hangs.
#pragma once

void watchdog_begin(void);

// Call it at least every 100 ms.
void watchdog_reset(void);

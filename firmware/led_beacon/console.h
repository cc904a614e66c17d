// Serial console: requests of the host and replies. README.md specifies the protocol.
#pragma once

// Play the frame stored in the EEPROM.
void console_begin(void);

// Process received requests, and return to the stored frame when a temporary one is finished.
void console_poll(void);

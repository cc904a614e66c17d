// Serial port: 115200 baud, 8 data bits, no parity, 1 stop bit.
#pragma once

#include <stdint.h>

void serial_port_begin(void);

// The next received byte, or -1 for none.
int16_t serial_port_read(void);

void serial_port_write(const char *text);

// Sleep until an interrupt, unless a byte has been received.
void serial_port_sleep(void);

// The serial line: 115200 baud, 8 bits, no parity, 1 stop bit.
#pragma once

#include <stdint.h>

void serial_port_begin(void);

// The next byte that came, or -1 for none.
int16_t serial_port_read(void);

void serial_port_write(const char *text);

// Sleep until an interrupt, but not while a byte waits.
void serial_port_sleep(void);

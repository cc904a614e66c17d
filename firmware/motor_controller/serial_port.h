// The serial line: 57600 baud, 8 bits, no parity, 1 stop bit.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define BAUD 57600UL
// At most so many bytes are written at a time.
#define WRITTEN_MAX 32
// Stands for bytes that came damaged or found no room.
#define DAMAGED_BYTE 0

void serial_port_begin(void);

// The next byte that came, or -1 for none.
int16_t serial_port_read(void);

// Whether all that was written is on its way, so there is room for WRITTEN_MAX bytes.
bool serial_port_is_free(void);

// Never waits; what does not fit is lost.
void serial_port_write(const char *text);

// Sleep until an interrupt, but not while a byte waits that can be answered.
void serial_port_sleep(void);

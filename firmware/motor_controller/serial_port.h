// The serial line: 57600 baud, 8 bits, no parity, 1 stop bit.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define BAUD 57600UL
// Size of the transmit buffer.
#define WRITTEN_MAX 32
// Replaces corrupted bytes and bytes lost by overflow.
#define DAMAGED_BYTE 0

void serial_port_begin(void);

// The next received byte, or -1 for none.
int16_t serial_port_read(void);

// Whether the transmit buffer is empty, so that it has room for WRITTEN_MAX bytes.
bool serial_port_is_free(void);

// Never blocks; bytes that do not fit are lost.
void serial_port_write(const char *text);

// Sleep until an interrupt, unless a received byte can be processed.
void serial_port_sleep(void);

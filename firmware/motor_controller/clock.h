// Milliseconds since reset, from Timer2.
#pragma once

#include <stdint.h>

void clock_begin(void);

// Modulo 65536.
uint16_t clock_milliseconds(void);

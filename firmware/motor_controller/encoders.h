// Quadrature encoders: left A on D2 and B on D3, right A on A4 and B on A5. Every edge counts; A before B is forward.
#pragma once

#include <stdint.h>

#include "wheels.h"

void encoders_begin(void);

// Both counts at the same time; they wrap around at 32 bits.
void encoders_read(int32_t ticks[WHEEL_COUNT]);

void encoders_reset(void);

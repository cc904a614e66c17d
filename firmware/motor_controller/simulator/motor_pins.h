// What the pins tell an H-bridge, read from the registers as the datasheet explains them.
#pragma once

#include <simavr/sim_avr.h>

// Mean voltage of a motor as a part of the supply, -1 to 1; 0 while the bridge is not enabled.
double left_voltage(const avr_t *avr);
double right_voltage(const avr_t *avr);

// Inputs of the H-bridge, computed from the registers as in the datasheet.
#pragma once

#include <simavr/sim_avr.h>

// Mean voltage of a motor as a fraction of the supply, -1 to 1; 0 while the bridge is disabled.
double left_voltage(const avr_t *avr);
double right_voltage(const avr_t *avr);

// Records the lamp's pins as a value change dump: `half_a`, `half_b`, and `preparing` while the interrupt runs that
// prepares the next step.
#pragma once

#include <simavr/sim_avr.h>
#include <stdbool.h>

// Start recording to a file; false if it cannot be written.
bool pins_begin(avr_t *avr, const char *path);

// False if not everything could be written.
bool pins_end(void);

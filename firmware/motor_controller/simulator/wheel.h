// A wheel with a motor (first-order lag from voltage to speed) and a quadrature encoder.
#pragma once

#include <simavr/sim_avr.h>
#include <stdint.h>

struct wheel {
    // Port and pin of the encoder's A; B is on the next pin.
    char port;
    uint8_t a;
    // Speed at full voltage [ticks/s], and time constant [s].
    double speed_max, lag;
    double speed, position;
    int64_t ticks;
};

// Set the encoder's levels at the controller's inputs.
void wheel_show(const struct wheel *wheel, avr_t *avr);

// Advance by `seconds`, by at most one tick.
void wheel_turn(struct wheel *wheel, avr_t *avr, double voltage, double seconds);

// A wheel on a motor whose speed follows its voltage with a first order lag, and its quadrature encoder.
#pragma once

#include <simavr/sim_avr.h>
#include <stdint.h>

struct wheel {
    // Of the encoder: A is on this pin, B on the next one.
    char port;
    uint8_t a;
    // At full voltage [ticks/s], and of the lag [s].
    double speed_max, lag;
    double speed, position;
    int64_t ticks;
};

// Show the encoder's levels to a controller that was just switched on.
void wheel_show(const struct wheel *wheel, avr_t *avr);

// Let `seconds` pass; at most one tick comes of it.
void wheel_turn(struct wheel *wheel, avr_t *avr, double voltage, double seconds);

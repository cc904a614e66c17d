// Two motors on an H-bridge with two inputs per motor. The input of the direction gets PWM of 490 Hz, the other one is
// low.
//
//            forward  backward  enable
//   left     D10      D6        D13
//   right    D9       D5        D12
#pragma once

#include <stdint.h>

#include "wheels.h"

#define PWM_MAX 255

// Set all inputs low and enable both motors.
void motors_begin(void);

// From -PWM_MAX (full speed backward) to PWM_MAX.
void motors_set(const int16_t pwm[WHEEL_COUNT]);

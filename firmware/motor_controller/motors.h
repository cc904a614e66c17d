// Two motors behind an H-bridge that takes two inputs a motor. PWM of 490 Hz is on the one that stands for the direction,
// the other one is low.
//
//            forward  backward  enable
//   left     D10      D6        D13
//   right    D9       D5        D12
#pragma once

#include <stdint.h>

#include "wheels.h"

#define PWM_MAX 255

// All inputs low, both motors enabled.
void motors_begin(void);

// From -PWM_MAX, full backward, to PWM_MAX.
void motors_set(const int16_t pwm[WHEEL_COUNT]);

// What both wheels do: nothing, a raw PWM, or a speed that is held. It ends DRIVE_MILLISECONDS after the last order.
#pragma once

#include <stdint.h>

#include "speed_loop.h"
#include "wheels.h"

#define DRIVE_MILLISECONDS 2000
#define FRAME_MILLISECONDS 33

// Within TICKS_PER_FRAME_MAX; two zeros switch both motors off.
void drive_at_speed(const int16_t ticks_per_frame[WHEEL_COUNT]);

// Within PWM_MAX.
void drive_with_pwm(const int16_t pwm[WHEEL_COUNT]);

void drive_set_gains(const struct gains *gains);

// Count from zero; a speed that is held ends, a raw PWM does not.
void drive_reset_encoders(void);

// Hold the speed and watch the time.
void drive_poll(void);

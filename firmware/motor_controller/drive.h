// State of both wheels: stopped, raw PWM, or speed control. Auto-stop DRIVE_MILLISECONDS after the last command.
#pragma once

#include <stdint.h>

#include "speed_loop.h"
#include "wheels.h"

#define DRIVE_MILLISECONDS 2000
#define FRAME_MILLISECONDS 33

// Speeds within TICKS_PER_FRAME_MAX; two zeros switch both motors off.
void drive_at_speed(const int16_t ticks_per_frame[WHEEL_COUNT]);

// Values within PWM_MAX.
void drive_with_pwm(const int16_t pwm[WHEEL_COUNT]);

void drive_set_gains(const struct gains *gains);

// Reset the counts to zero; this ends speed control, but not raw PWM.
void drive_reset_encoders(void);

// Run the speed control and the auto-stop.
void drive_poll(void);

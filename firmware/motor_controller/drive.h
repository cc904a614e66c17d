// State of both wheels: stopped, raw PWM, or speed control. Auto-stop a time after the last command.
#pragma once

#include <stdint.h>

#include "speed_loop.h"
#include "wheels.h"

// Of the auto-stop [ms]; the longest is that after a reset.
#define AUTO_STOP_MIN 200
#define AUTO_STOP_MAX 2000
#define FRAME_MILLISECONDS 33

// Speeds within TICKS_PER_FRAME_MAX; two zeros switch both motors off.
void drive_at_speed(const int16_t ticks_per_frame[WHEEL_COUNT]);

// Values within PWM_MAX.
void drive_with_pwm(const int16_t pwm[WHEEL_COUNT]);

void drive_set_gains(const struct gains *gains);

// From AUTO_STOP_MIN to AUTO_STOP_MAX.
void drive_set_auto_stop(uint16_t milliseconds);

// Reset the counts to zero; this ends speed control, but not raw PWM.
void drive_reset_encoders(void);

// Run the speed control and the auto-stop.
void drive_poll(void);

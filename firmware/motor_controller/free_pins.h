// Pins that are not used by motors, encoders or the serial line, in Arduino's numbering: digital 4, 7, 8, 11 and 14 to
// 17 (A0 to A3), analog 0 to 3, 6 and 7.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define FREE_PIN_MAX 17
#define FREE_CHANNEL_MAX 7

bool free_pin_is(uint8_t pin);
bool free_channel_is(uint8_t channel);

// The pin must be free.
bool free_pin_read(uint8_t pin);

// Return false if the pin is not free.
bool free_pin_direct(uint8_t pin, bool is_output);

// Sets the pull-up of an input. Return false if the pin is not free.
bool free_pin_write(uint8_t pin, bool is_high);

// The channel must be free; 0 to 1023 for 0 to 5 V.
uint16_t free_channel_read(uint8_t channel);

// Numbers as the serial line has them: digits, perhaps after a minus, and nothing else.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define NUMBERS_MAX 4

struct range {
    int16_t min, max;
};

// Read exactly `count` numbers with one separator between two of them; false, with `numbers` undefined, where the text is
// anything else or one lies outside its range.
bool numbers_read(const char *text, char separator, const struct range *ranges, uint8_t count, int16_t *numbers);

// Parser of decimal integers: an optional minus and digits, nothing else.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define NUMBERS_MAX 4

struct range {
    int16_t min, max;
};

// Parse exactly `count` numbers with one separator between them; false, with `numbers` undefined, if the text is malformed
// or a number is out of its range.
bool numbers_read(const char *text, char separator, const struct range *ranges, uint8_t count, int16_t *numbers);

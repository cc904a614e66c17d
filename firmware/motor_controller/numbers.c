#include "numbers.h"

#define DIGITS_MAX 5

// Parse one number and advance past it.
static bool read_one(const char **text, struct range range, int16_t *number)
{
    bool is_negative = **text == '-';
    int32_t size = 0;
    uint8_t digits = 0;
    for (*text += is_negative; **text >= '0' && **text <= '9' && digits < DIGITS_MAX; digits++)
        size = size * 10 + *(*text)++ - '0';
    int32_t value = is_negative ? -size : size;
    *number = value;
    return digits && value >= range.min && value <= range.max;
}

bool numbers_read(const char *text, char separator, const struct range *ranges, uint8_t count, int16_t *numbers)
{
    for (uint8_t i = 0; i < count; i++) {
        if (i && *text++ != separator)
            return false;
        if (!read_one(&text, ranges[i], &numbers[i]))
            return false;
    }
    return !*text;
}

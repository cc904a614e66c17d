#include "commands.h"

#include <stdio.h>
#include <string.h>
#include <util/crc16.h>

#include "drive.h"
#include "encoders.h"
#include "free_pins.h"
#include "motors.h"
#include "numbers.h"
#include "serial_port.h"

#define SPEED {-TICKS_PER_FRAME_MAX, TICKS_PER_FRAME_MAX}
#define PWM {-PWM_MAX, PWM_MAX}
#define GAIN {0, GAIN_MAX}
#define DIVISOR {1, GAIN_MAX}
#define PIN {0, FREE_PIN_MAX}
#define CHANNEL {0, FREE_CHANNEL_MAX}
#define SWITCH {0, 1}
#define AUTO_STOP {AUTO_STOP_MIN, AUTO_STOP_MAX}

// "*", two digits and the end of the text.
#define SUFFIX_SIZE 4

// Whether the host sends checksums.
static bool is_checksummed;

// Executes a command with arguments within their ranges; false on failure.
typedef bool action(const int16_t *numbers);

struct command {
    char letter;
    action *act;
    uint8_t count;
    char separator;
    struct range ranges[NUMBERS_MAX];
};

// "*" and the CRC-8 (polynomial 0x07, initial value 0) of a text as two hexadecimal digits.
static void write_suffix(const char *text, char suffix[SUFFIX_SIZE])
{
    uint8_t crc = 0;
    while (*text)
        crc = _crc8_ccitt_update(crc, *text++);
    sprintf(suffix, "*%02X", crc);
}

static bool reply(const char *text)
{
    char suffix[SUFFIX_SIZE] = "";
    if (is_checksummed)
        write_suffix(text, suffix);
    serial_port_write(text);
    serial_port_write(suffix);
    serial_port_write("\r\n");
    return true;
}

static bool reply_number(int16_t number)
{
    char text[8];
    sprintf(text, "%d", number);
    return reply(text);
}

static bool send_baud(const int16_t *numbers)
{
    (void)numbers;
    char text[8];
    sprintf(text, "%lu", BAUD);
    return reply(text);
}

static bool send_encoders(const int16_t *numbers)
{
    (void)numbers;
    int32_t ticks[WHEEL_COUNT];
    char text[24];
    encoders_read(ticks);
    sprintf(text, "%ld %ld", ticks[LEFT], ticks[RIGHT]);
    return reply(text);
}

static bool reset_encoders(const int16_t *numbers)
{
    (void)numbers;
    drive_reset_encoders();
    return reply("OK");
}

static bool hold_speed(const int16_t *numbers)
{
    drive_at_speed(numbers);
    return reply("OK");
}

static bool set_pwm(const int16_t *numbers)
{
    drive_with_pwm(numbers);
    return reply("OK");
}

static bool set_gains(const int16_t *numbers)
{
    struct gains gains = {.p = numbers[0], .d = numbers[1], .i = numbers[2], .o = numbers[3]};
    drive_set_gains(&gains);
    return reply("OK");
}

static bool set_auto_stop(const int16_t *numbers)
{
    drive_set_auto_stop(numbers[0]);
    return reply("OK");
}

static bool read_analog(const int16_t *numbers)
{
    return free_channel_is(numbers[0]) && reply_number(free_channel_read(numbers[0]));
}

static bool read_pin(const int16_t *numbers)
{
    return free_pin_is(numbers[0]) && reply_number(free_pin_read(numbers[0]));
}

static bool direct_pin(const int16_t *numbers)
{
    return free_pin_direct(numbers[0], numbers[1]) && reply("OK");
}

static bool write_pin(const int16_t *numbers)
{
    return free_pin_write(numbers[0], numbers[1]) && reply("OK");
}

static const struct command commands[] = {
    {'b', send_baud, 0, 0, {}},
    {'e', send_encoders, 0, 0, {}},
    {'r', reset_encoders, 0, 0, {}},
    {'m', hold_speed, 2, ' ', {SPEED, SPEED}},
    {'o', set_pwm, 2, ' ', {PWM, PWM}},
    {'u', set_gains, 4, ':', {GAIN, GAIN, GAIN, DIVISOR}},
    {'h', set_auto_stop, 1, ' ', {AUTO_STOP}},
    {'a', read_analog, 1, ' ', {CHANNEL}},
    {'d', read_pin, 1, ' ', {PIN}},
    {'c', direct_pin, 2, ' ', {PIN, SWITCH}},
    {'w', write_pin, 2, ' ', {PIN, SWITCH}},
};

// Parse the arguments.
static bool read_numbers(const struct command *command, const char *text, int16_t *numbers)
{
    if (!command->count)
        return !*text;
    return *text == ' ' && numbers_read(text + 1, command->separator, command->ranges, command->count, numbers);
}

static bool execute(const char *line)
{
    int16_t numbers[NUMBERS_MAX];
    for (uint8_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        if (commands[i].letter == line[0])
            return read_numbers(&commands[i], line + 1, numbers) && commands[i].act(numbers);
    }
    return false;
}

// Verify and remove the checksum. From the first valid one on, plain lines are refused: they may be damaged ones. Only a
// plain stop is accepted, and "b", by which a host without checksums begins.
static bool check(char *line)
{
    char suffix[SUFFIX_SIZE];
    char *received = strchr(line, '*');
    if (received) {
        *received = 0;
        write_suffix(line, suffix);
        if (strcmp(received + 1, suffix + 1))
            return false;
        is_checksummed = true;
        return true;
    }
    if (!strcmp(line, "b"))
        is_checksummed = false;
    return !is_checksummed || !strcmp(line, "m 0 0");
}

void commands_execute(char *line)
{
    if (!check(line) || !execute(line))
        reply("Invalid Command");
}

#include "console.h"

#include <stdbool.h>
#include <stdint.h>

#include "commands.h"
#include "serial_port.h"

// The longest valid line is u with four gains of five digits and a checksum.
#define LINE_MAX 28

static char line[LINE_MAX + 1];
static uint8_t line_length;
static bool line_is_damaged;

static void end_line(void)
{
    line[line_length] = 0;
    if (line_is_damaged)
        line[0] = 0;
    commands_execute(line);
    line_length = 0;
    line_is_damaged = false;
}

static void add(char byte)
{
    if (byte == DAMAGED_BYTE || line_length == LINE_MAX)
        line_is_damaged = true;
    else
        line[line_length++] = byte;
}

void console_poll(void)
{
    int16_t byte;
    while (serial_port_is_free() && (byte = serial_port_read()) >= 0) {
        bool is_at_begin = !line_length && !line_is_damaged;
        if (byte == '\r')
            end_line();
        // Skip the LF of hosts that end lines with CR and LF.
        else if (byte != '\n' || !is_at_begin)
            add(byte);
    }
}

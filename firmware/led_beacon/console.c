#include "console.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "frame.h"
#include "player.h"
#include "serial_port.h"
#include "store.h"

#define PROTOCOL_VERSION 1
#define LINE_MAX 80
// An upload without data for this many repetitions of the frame is dropped in favour of the stored frame.
#define RESTING_ROUNDS_MAX 2

static char line[LINE_MAX + 1];
static uint8_t line_length;
static bool line_is_too_long;

static bool is_uploading, has_kept_frame;
// The player's frame that is stored in the EEPROM.
static const uint8_t *kept_frame;
static uint16_t upload_length, uploaded;
static uint8_t upload_round;

static void reply(const char *text)
{
    serial_port_write(text);
    serial_port_write("\r\n");
}

static void reply_error(const char *why)
{
    serial_port_write("ERR ");
    reply(why);
}

static void reply_version(void)
{
    char text[24];
    sprintf(text, "led_beacon %d %d", PROTOCOL_VERSION, FRAME_MAX);
    reply(text);
}

// State, source, length and checksum of the frame, and whether another frame is queued.
static void reply_status(void)
{
    char text[48];
    const uint8_t *frame = player_frame();
    uint16_t length = frame ? frame_header_of(frame)->length : 0;
    uint16_t crc = frame ? frame[length - 2] << 8 | frame[length - 1] : 0;
    const char *source = !frame ? "none" : frame == kept_frame ? "kept" : "temporary";
    sprintf(text, "%s %s %u %04x %d", player_is_playing() ? "playing" : "steady", source, length, crc,
            !player_free_frame());
    reply(text);
}

static void begin_upload(const char *arguments)
{
    uint32_t length = strtoul(arguments, 0, 10);
    if (!player_free_frame())
        return reply_error("busy");
    is_uploading = false;
    if (length < 1 || length > FRAME_MAX)
        return reply_error("length");
    is_uploading = true;
    upload_length = length;
    uploaded = 0;
    reply("OK");
}

static int8_t hex_digit(char digit)
{
    if (digit >= '0' && digit <= '9')
        return digit - '0';
    digit |= 'a' ^ 'A';
    return digit >= 'a' && digit <= 'f' ? digit - 'a' + 10 : -1;
}

static void receive_data(const char *arguments)
{
    char *hex;
    uint32_t at = strtoul(arguments, &hex, 10);
    if (!is_uploading)
        return reply_error("begin");
    // A line may be repeated if its reply was lost, but none may be skipped.
    if (*hex != ' ' || at > uploaded)
        return reply_error("offset");
    uint8_t *frame = player_free_frame();
    for (hex++; *hex; hex += 2) {
        int8_t high = hex_digit(hex[0]), low = high < 0 ? -1 : hex_digit(hex[1]);
        if (low < 0)
            return reply_error("hex");
        if (at >= upload_length)
            return reply_error("length");
        frame[at++] = high << 4 | low;
    }
    if (at > uploaded)
        uploaded = at;
    reply("OK");
}

static void end_upload(bool is_kept)
{
    if (!is_uploading)
        return reply_error("begin");
    is_uploading = false;
    uint8_t *frame = player_free_frame();
    const char *fault = uploaded == upload_length ? frame_fault(frame, uploaded) : "length";
    if (fault)
        return reply_error(fault);
    if (is_kept && !store_write(frame))
        return reply_error("eeprom");
    has_kept_frame |= is_kept;
    kept_frame = is_kept ? frame : kept_frame == frame ? 0 : kept_frame;
    player_play_free_frame();
    reply("OK");
}

static void execute(const char *arguments)
{
    switch (line[0]) {
    case 'v': return reply_version();
    case 's': return reply_status();
    case 'b': return begin_upload(arguments);
    case 'd': return receive_data(arguments);
    case 'k': return end_upload(true);
    case 't': return end_upload(false);
    case 'h': player_stop(); return reply("OK");
    case 'p': return player_resume() ? reply("OK") : reply_error("none");
    default: reply_error("command");
    }
}

static void end_line(void)
{
    line[line_length] = 0;
    upload_round = player_rounds();
    if (line_is_too_long)
        reply_error("line");
    else if (line_length)
        execute(line + 1);
    line_length = 0;
    line_is_too_long = false;
}

static void play_kept_frame(void)
{
    is_uploading = false;
    uint8_t *frame = player_free_frame();
    has_kept_frame = store_read(frame);
    if (!has_kept_frame)
        return;
    kept_frame = frame;
    player_play_free_frame();
}

void console_begin(void)
{
    play_kept_frame();
}

void console_poll(void)
{
    int16_t byte;
    while ((byte = serial_port_read()) >= 0) {
        if (byte == '\r')
            end_line();
        else if (byte == '\n')
            continue;
        else if (line_length < LINE_MAX)
            line[line_length++] = byte;
        else
            line_is_too_long = true;
    }
    bool rests = (uint8_t)(player_rounds() - upload_round) >= RESTING_ROUNDS_MAX;
    if (has_kept_frame && player_is_done() && (!is_uploading || rests))
        play_kept_frame();
}

#include "frame.h"

#include <util/crc16.h>

static bool header_is_playable(const struct frame_header *header)
{
    if (header->pattern_length < 1 || header->pattern_length > PATTERN_MAX)
        return false;
    if (header->bits < 1 || header->bits > BITS_MAX)
        return false;
    if (header->pulse_trains < 1 << header->bits || header->pulse_trains > PULSE_TRAINS_MAX)
        return false;
    if (header->preamble_length > PREAMBLE_MAX)
        return false;
    for (uint8_t i = 0; i < header->preamble_length; i++)
        if (header->preamble[i] >= header->pulse_trains)
            return false;
    return true;
}

static bool pulse_train_is_playable(const struct pulse_train *train, uint8_t pattern_length)
{
    uint16_t ticks = train->step_time >> 16;
    return ticks >= STEP_TICKS_MIN && ticks <= STEP_TICKS_MAX && train->steps && train->first_index < pattern_length;
}

static bool sections_fill(const uint8_t *begin, const uint8_t *end, uint8_t bits)
{
    if (begin == end)
        return false;
    while (begin < end) {
        const struct section *section = (const struct section *)begin;
        if (end - begin < (int)sizeof(struct section))
            return false;
        if (!section->bursts || !section->repeats || !section->symbols)
            return false;
        uint32_t all = (uint32_t)section->bursts * section->symbols * bits;
        if (all > 8UL * FRAME_MAX)
            return false;
        begin += sizeof(struct section);
        if (end - begin < (int)frame_bits_length(section, bits))
            return false;
        begin += frame_bits_length(section, bits);
    }
    return true;
}

const char *frame_fault(const uint8_t *frame, uint16_t length)
{
    const struct frame_header *header = frame_header_of(frame);
    if (length < sizeof(struct frame_header) + FRAME_CRC_LENGTH || length > FRAME_MAX)
        return "length";
    // The CRC of data followed by its CRC is 0.
    if (frame_crc(frame, length))
        return "crc";
    if (header->version != FRAME_VERSION)
        return "version";
    if (header->length != length)
        return "length";
    if (!header_is_playable(header))
        return "header";
    const uint8_t *begin = frame_sections_of(frame), *end = frame + length - FRAME_CRC_LENGTH;
    if (begin > end)
        return "trains";
    for (uint8_t i = 0; i < header->pulse_trains; i++)
        if (!pulse_train_is_playable(frame_pulse_trains_of(frame) + i, header->pattern_length))
            return "trains";
    return sections_fill(begin, end, header->bits) ? 0 : "sections";
}

uint16_t frame_crc(const uint8_t *data, uint16_t length)
{
    uint16_t crc = 0;
    while (length--)
        crc = _crc_xmodem_update(crc, *data++);
    return crc;
}

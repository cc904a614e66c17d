// Frame: the signal of the lamp, computed by the host. README.md specifies every byte.
//
// The output pattern is a cycle of up to eight states of the lamp. A symbol is a pulse train: start index in the
// pattern, number of steps and duration of a step. A section is a packet: bursts of symbols, each preceded by the
// preamble and repeated. Sections fill the frame up to its checksum.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define FRAME_VERSION 1
#define FRAME_MAX 508
#define FRAME_CRC_LENGTH 2
#define PATTERN_MAX 8
#define PREAMBLE_MAX 2
#define BITS_MAX 3
#define PULSE_TRAINS_MAX 12

// Limits of a step: the interrupt must prepare the next step in time, and Timer1 has 16 bits.
#define STEP_TICKS_MIN 1000
#define STEP_TICKS_MAX 65000

// All numbers are little-endian.
struct frame_header {
    uint8_t version;
    uint8_t plays;
    uint16_t length;
    uint16_t pattern;
    uint8_t pattern_length;
    uint8_t bits;
    uint8_t pulse_trains;
    uint8_t preamble_length;
    uint8_t preamble[PREAMBLE_MAX];
} __attribute__((packed));

struct pulse_train {
    uint32_t step_time;
    uint16_t steps;
    uint8_t first_index;
} __attribute__((packed));

struct section {
    uint8_t bursts;
    uint8_t repeats;
    uint16_t symbols;
} __attribute__((packed));

// Reason why a frame is rejected, as reported on the serial port, or null for a valid frame.
const char *frame_fault(const uint8_t *frame, uint16_t length);

uint16_t frame_crc(const uint8_t *data, uint16_t length);

static inline const struct frame_header *frame_header_of(const uint8_t *frame)
{
    return (const struct frame_header *)frame;
}

static inline const struct pulse_train *frame_pulse_trains_of(const uint8_t *frame)
{
    return (const struct pulse_train *)(frame + sizeof(struct frame_header));
}

static inline const uint8_t *frame_sections_of(const uint8_t *frame)
{
    return frame + sizeof(struct frame_header) + frame_header_of(frame)->pulse_trains * sizeof(struct pulse_train);
}

static inline uint16_t frame_bits_length(const struct section *section, uint8_t bits)
{
    return ((uint32_t)section->bursts * section->symbols * bits + 7) / 8;
}

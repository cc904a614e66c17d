// What the lamp plays: a frame that the host computed. README.md describes every byte.
//
// A wheel of up to eight states of the lamp turns; a symbol is a train of steps along it: where it begins, how many
// steps it has and how long each of them lasts. A section is a packet: groups of symbols, each group with the marker
// before it and played several times. Sections fill the frame up to its checksum.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define FRAME_VERSION 1
#define FRAME_MAX 508
#define FRAME_CRC_LENGTH 2
#define WHEEL_MAX 8
#define MARKER_MAX 2
#define BITS_MAX 3
#define TRAINS_MAX 12

// A step shorter than this could end before the interrupt has prepared the next one; a longer one does not fit Timer1.
#define STEP_TICKS_MIN 1000
#define STEP_TICKS_MAX 65000

// All numbers have their lowest byte first, as the controller has them.
struct frame_header {
    uint8_t version;
    uint8_t plays;
    uint16_t length;
    uint16_t wheel;
    uint8_t wheel_length;
    uint8_t bits;
    uint8_t trains;
    uint8_t marker_length;
    uint8_t marker[MARKER_MAX];
} __attribute__((packed));

struct train {
    uint32_t step_time;
    uint16_t steps;
    uint8_t first_place;
} __attribute__((packed));

struct section {
    uint8_t groups;
    uint8_t repeats;
    uint16_t symbols;
} __attribute__((packed));

// Why a frame is refused, as the serial line calls it, or null for a frame that can be played.
const char *frame_fault(const uint8_t *frame, uint16_t length);

uint16_t frame_crc(const uint8_t *data, uint16_t length);

static inline const struct frame_header *frame_header_of(const uint8_t *frame)
{
    return (const struct frame_header *)frame;
}

static inline const struct train *frame_trains_of(const uint8_t *frame)
{
    return (const struct train *)(frame + sizeof(struct frame_header));
}

static inline const uint8_t *frame_sections_of(const uint8_t *frame)
{
    return frame + sizeof(struct frame_header) + frame_header_of(frame)->trains * sizeof(struct train);
}

static inline uint16_t frame_bits_length(const struct section *section, uint8_t bits)
{
    return ((uint32_t)section->groups * section->symbols * bits + 7) / 8;
}

#include "player.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#define HALVES (_BV(PORTB1) | _BV(PORTB2))
#define START_TICKS 2000

// Action of a compare match on the pins: clear, or set with the other bit.
#define MATCH_CLEARS (_BV(COM1A1) | _BV(COM1B1))
#define MATCH_SETS_A _BV(COM1A0)
#define MATCH_SETS_B _BV(COM1B0)

static uint8_t frames[2][FRAME_MAX];
static volatile uint8_t playing_index, rounds;
static volatile bool next_waits, is_done;
static bool has_frame, is_playing;
static uint8_t plays_left;

// Bit reader of a section; copy it to save the position.
struct bit_reader {
    const uint8_t *byte;
    uint8_t unread;
};

// Position in the frame.
static const uint8_t *frame;
static struct bit_reader reader, burst_begin;
static struct section section;
static uint8_t bursts_left, repeats_left, preamble_left;
static uint16_t symbols_left;

// Position in the symbol.
static uint32_t step_time, due;
static uint16_t steps_left, pattern_ahead;
static uint8_t states_ahead;

static uint8_t read_bits(uint8_t count)
{
    uint8_t bits = 0;
    while (count--) {
        if (!reader.unread) {
            reader.byte++;
            reader.unread = 8;
        }
        bits = bits << 1 | (*reader.byte >> --reader.unread & 1);
    }
    return bits;
}

static void begin_burst(void)
{
    preamble_left = frame_header_of(frame)->preamble_length;
    symbols_left = section.symbols;
}

static void begin_section(const uint8_t *begin)
{
    section = *(const struct section *)begin;
    reader.byte = begin + sizeof(struct section);
    reader.unread = 8;
    burst_begin = reader;
    bursts_left = section.bursts;
    repeats_left = section.repeats;
    begin_burst();
}

static void switch_frame(void)
{
    if (!next_waits)
        return;
    playing_index ^= 1;
    next_waits = false;
    plays_left = frame_header_of(frames[playing_index])->plays;
    is_done = false;
}

static void begin_frame(void)
{
    switch_frame();
    if (plays_left && !--plays_left)
        is_done = true;
    frame = frames[playing_index];
    begin_section(frame_sections_of(frame));
}

static void end_section(void)
{
    // Sections are padded to whole bytes.
    const uint8_t *next = reader.byte + 1;
    bool at_end = next + FRAME_CRC_LENGTH >= frame + frame_header_of(frame)->length;
    rounds += at_end;
    // The last repetition is always completed.
    if (at_end || (next_waits && !is_done))
        begin_frame();
    else
        begin_section(next);
}

static void end_burst(void)
{
    if (--repeats_left) {
        reader = burst_begin;
    } else if (--bursts_left) {
        burst_begin = reader;
        repeats_left = section.repeats;
    } else {
        end_section();
        return;
    }
    begin_burst();
}

static uint8_t next_symbol(void)
{
    if (!preamble_left && !symbols_left)
        end_burst();
    const struct frame_header *header = frame_header_of(frame);
    if (preamble_left)
        return header->preamble[header->preamble_length - preamble_left--];
    symbols_left--;
    return read_bits(header->bits);
}

static void begin_symbol(void)
{
    uint8_t symbol = next_symbol();
    // Read the header after next_symbol(), which may have switched to another frame.
    const struct pulse_train *train = frame_pulse_trains_of(frame) + symbol;
    const struct frame_header *header = frame_header_of(frame);
    step_time = train->step_time;
    steps_left = train->steps;
    pattern_ahead = header->pattern >> 2 * train->first_index;
    states_ahead = header->pattern_length - train->first_index;
}

// Set the pin action and the time of the next step in Timer1.
static void prepare_step(void)
{
    if (!steps_left)
        begin_symbol();
    steps_left--;
    uint8_t state = pattern_ahead;
    pattern_ahead >>= 2;
    if (!--states_ahead) {
        pattern_ahead = frame_header_of(frame)->pattern;
        states_ahead = frame_header_of(frame)->pattern_length;
    }
    uint16_t when = due >> 16;
    OCR1A = when;
    OCR1B = when;
    TCCR1A = MATCH_CLEARS | (state & 1 ? MATCH_SETS_A : 0) | (state & 2 ? MATCH_SETS_B : 0);
    due += step_time;
}

ISR(TIMER1_COMPA_vect)
{
    prepare_step();
}

static void start(void)
{
    begin_frame();
    steps_left = 0;
    due = (uint32_t)(uint16_t)(TCNT1 + START_TICKS) << 16 | 0x8000;
    // Hand the pins over from the port to Timer1, both on.
    TCCR1A = MATCH_CLEARS | MATCH_SETS_A | MATCH_SETS_B;
    TCCR1C = _BV(FOC1A) | _BV(FOC1B);
    prepare_step();
    TIFR1 = _BV(OCF1A);
    TIMSK1 = _BV(OCIE1A);
    is_playing = true;
}

void player_begin(void)
{
    PORTB |= HALVES;
    DDRB |= HALVES;
    TCCR1A = 0;
    TCCR1B = _BV(CS10);
}

uint8_t *player_free_frame(void)
{
    return next_waits ? 0 : frames[playing_index ^ 1];
}

void player_play_free_frame(void)
{
    has_frame = true;
    next_waits = true;
    if (!is_playing)
        player_resume();
}

void player_stop(void)
{
    TIMSK1 = 0;
    TCCR1A = 0;
    PORTB |= HALVES;
    is_playing = false;
    switch_frame();
}

bool player_resume(void)
{
    if (has_frame && !is_playing)
        ATOMIC_BLOCK(ATOMIC_RESTORESTATE) start();
    return has_frame;
}

bool player_is_playing(void)
{
    return is_playing;
}

bool player_is_done(void)
{
    return is_playing && is_done && !next_waits;
}

uint8_t player_rounds(void)
{
    return rounds;
}

const uint8_t *player_frame(void)
{
    return has_frame ? frames[playing_index] : 0;
}

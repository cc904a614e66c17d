#include "encoders.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

// B is the next pin after A.
#define LEFT_A PD2
#define RIGHT_A PC4
#define PAIR 3

// Count of the transition between two states of B and A. Two edges at once have no direction and count 0.
static const int8_t ticks_of_step[4][4] = {
    [0] = {[1] = 1, [2] = -1},
    [1] = {[3] = 1, [0] = -1},
    [3] = {[2] = 1, [1] = -1},
    [2] = {[0] = 1, [3] = -1},
};
// Unsigned, since signed overflow is undefined.
static volatile uint32_t counts[WHEEL_COUNT];
static uint8_t states[WHEEL_COUNT];

static uint8_t left_state(void)
{
    return PIND >> LEFT_A & PAIR;
}

static uint8_t right_state(void)
{
    return PINC >> RIGHT_A & PAIR;
}

static inline void step(enum wheel wheel, uint8_t state)
{
    counts[wheel] += ticks_of_step[states[wheel]][state];
    states[wheel] = state;
}

ISR(PCINT2_vect)
{
    step(LEFT, left_state());
}

ISR(PCINT1_vect)
{
    step(RIGHT, right_state());
}

void encoders_begin(void)
{
    // Pull-ups, since most encoders have open collectors.
    PORTD |= PAIR << LEFT_A;
    PORTC |= PAIR << RIGHT_A;
    states[LEFT] = left_state();
    states[RIGHT] = right_state();
    PCMSK2 = PAIR << LEFT_A;
    PCMSK1 = PAIR << RIGHT_A;
    PCICR = _BV(PCIE1) | _BV(PCIE2);
}

void encoders_read(int32_t ticks[WHEEL_COUNT])
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        ticks[LEFT] = counts[LEFT];
        ticks[RIGHT] = counts[RIGHT];
    }
}

void encoders_reset(void)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
        counts[LEFT] = counts[RIGHT] = 0;
}

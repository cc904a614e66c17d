#include "clock.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#define PRESCALER 64

static volatile uint16_t milliseconds;

ISR(TIMER2_COMPA_vect)
{
    milliseconds++;
}

void clock_begin(void)
{
    OCR2A = F_CPU / PRESCALER / 1000 - 1;
    TCCR2A = _BV(WGM21);
    TIMSK2 = _BV(OCIE2A);
    TCCR2B = _BV(CS22);
}

uint16_t clock_milliseconds(void)
{
    uint16_t now;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
        now = milliseconds;
    return now;
}

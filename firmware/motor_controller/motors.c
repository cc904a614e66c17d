#include "motors.h"

#include <avr/io.h>

static uint8_t forward(int16_t pwm)
{
    return pwm > 0 ? pwm : 0;
}

static uint8_t backward(int16_t pwm)
{
    return pwm < 0 ? -pwm : 0;
}

void motors_begin(void)
{
    // 8-bit phase correct PWM: unlike fast PWM it has no spike at zero. Compare registers are zero after reset.
    TCCR0A = _BV(COM0A1) | _BV(COM0B1) | _BV(WGM00);
    TCCR1A = _BV(COM1A1) | _BV(COM1B1) | _BV(WGM10);
    TCCR0B = _BV(CS01) | _BV(CS00);
    TCCR1B = _BV(CS11) | _BV(CS10);
    DDRD |= _BV(DDD5) | _BV(DDD6);
    DDRB |= _BV(DDB1) | _BV(DDB2) | _BV(DDB4) | _BV(DDB5);
    PORTB |= _BV(PORTB4) | _BV(PORTB5);
}

void motors_set(const int16_t pwm[WHEEL_COUNT])
{
    OCR1B = forward(pwm[LEFT]);
    OCR0A = backward(pwm[LEFT]);
    OCR1A = forward(pwm[RIGHT]);
    OCR0B = backward(pwm[RIGHT]);
}

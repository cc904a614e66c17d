#include "free_pins.h"

#include <avr/io.h>

#define FREE_PINS (1UL << 4 | 1UL << 7 | 1UL << 8 | 1UL << 11 | 0xfUL << 14)
#define FREE_CHANNELS 0xcf
#define FIRST_OF_B 8
#define FIRST_OF_C 14

// Registers of a port, at consecutive addresses.
struct port {
    volatile uint8_t pin, ddr, port;
};

static struct port *port_of(uint8_t pin)
{
    volatile uint8_t *first = pin >= FIRST_OF_C ? &PINC : pin >= FIRST_OF_B ? &PINB : &PIND;
    return (struct port *)first;
}

static uint8_t mask_of(uint8_t pin)
{
    return 1 << (pin >= FIRST_OF_C ? pin - FIRST_OF_C : pin % FIRST_OF_B);
}

static void set(volatile uint8_t *bits, uint8_t mask, bool is_set)
{
    *bits = is_set ? *bits | mask : *bits & ~mask;
}

bool free_pin_is(uint8_t pin)
{
    return FREE_PINS >> pin & 1;
}

bool free_channel_is(uint8_t channel)
{
    return FREE_CHANNELS >> channel & 1;
}

bool free_pin_read(uint8_t pin)
{
    return port_of(pin)->pin & mask_of(pin);
}

bool free_pin_direct(uint8_t pin, bool is_output)
{
    if (free_pin_is(pin))
        set(&port_of(pin)->ddr, mask_of(pin), is_output);
    return free_pin_is(pin);
}

bool free_pin_write(uint8_t pin, bool is_high)
{
    if (free_pin_is(pin))
        set(&port_of(pin)->port, mask_of(pin), is_high);
    return free_pin_is(pin);
}

uint16_t free_channel_read(uint8_t channel)
{
    ADMUX = _BV(REFS0) | channel;
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
    loop_until_bit_is_clear(ADCSRA, ADSC);
    return ADC;
}

#include "serial_port.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdbool.h>

#define BAUD 115200UL
#define RECEIVED_MAX 64

static volatile char received[RECEIVED_MAX];
static volatile uint8_t received_end;
static uint8_t received_begin;

ISR(USART_RX_vect)
{
    // On overflow the oldest byte is overwritten: the line is corrupted either way, which the checksum detects.
    received[received_end] = UDR0;
    received_end = (received_end + 1) % RECEIVED_MAX;
}

void serial_port_begin(void)
{
    UCSR0A = _BV(U2X0);
    UBRR0 = (F_CPU / 4 / BAUD - 1) / 2;
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

static bool is_empty(void)
{
    return received_begin == received_end;
}

int16_t serial_port_read(void)
{
    if (is_empty())
        return -1;
    uint8_t byte = received[received_begin];
    received_begin = (received_begin + 1) % RECEIVED_MAX;
    return byte;
}

void serial_port_write(const char *text)
{
    while (*text) {
        loop_until_bit_is_set(UCSR0A, UDRE0);
        UDR0 = *text++;
    }
}

void serial_port_sleep(void)
{
    cli();
    if (is_empty()) {
        sleep_enable();
        // Interrupts are enabled only after the instruction that follows sei.
        sei();
        sleep_cpu();
        sleep_disable();
    }
    sei();
}

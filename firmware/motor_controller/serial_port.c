#include "serial_port.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <util/atomic.h>

#define RECEIVED_MAX 64

static volatile uint8_t received[RECEIVED_MAX];
static volatile uint8_t received_begin, received_count;
static char written[WRITTEN_MAX];
static volatile uint8_t written_begin, written_end;

ISR(USART_RX_vect)
{
    // The error flags belong to the byte and are cleared when it is read.
    uint8_t faults = UCSR0A & (_BV(FE0) | _BV(DOR0));
    uint8_t byte = UDR0;
    if (received_count == RECEIVED_MAX)
        received[(received_begin + RECEIVED_MAX - 1) % RECEIVED_MAX] = DAMAGED_BYTE;
    else
        received[(received_begin + received_count++) % RECEIVED_MAX] = faults ? DAMAGED_BYTE : byte;
}

ISR(USART_UDRE_vect)
{
    UDR0 = written[written_begin++];
    if (written_begin == written_end)
        UCSR0B &= ~_BV(UDRIE0);
}

void serial_port_begin(void)
{
    UCSR0A = _BV(U2X0);
    UBRR0 = (F_CPU / 4 / BAUD - 1) / 2;
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

int16_t serial_port_read(void)
{
    int16_t byte = -1;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        if (received_count) {
            byte = received[received_begin];
            received_begin = (received_begin + 1) % RECEIVED_MAX;
            received_count--;
        }
    }
    return byte;
}

bool serial_port_is_free(void)
{
    return written_begin == written_end;
}

void serial_port_write(const char *text)
{
    if (serial_port_is_free())
        written_begin = written_end = 0;
    while (*text && written_end < WRITTEN_MAX) {
        written[written_end] = *text++;
        written_end++;
    }
    // Kept short so that no encoder edge is lost.
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        if (!serial_port_is_free())
            UCSR0B |= _BV(UDRIE0);
    }
}

void serial_port_sleep(void)
{
    cli();
    if (!received_count || !serial_port_is_free()) {
        sleep_enable();
        // The instruction after sei is executed before any interrupt.
        sei();
        sleep_cpu();
        sleep_disable();
    }
    sei();
}

// shirube LED beacon: a ceiling lamp that blinks its ID and messages to robots. For Arduino Uno and Nano (ATmega328P,
// 16 MHz). The host computes all that is played; see README.md.

#include <avr/interrupt.h>

extern "C" {
#include "console.h"
#include "player.h"
#include "serial_port.h"
}

// In place of setup() and loop(): the Arduino core, its timers and its Serial stay out, so this is the same program
// with and without it.
int main()
{
    player_begin();
    serial_port_begin();
    sei();
    console_begin();
    for (;;) {
        console_poll();
        serial_port_sleep();
    }
}

// shirube LED beacon: a ceiling lamp that sends its ID and messages to robots. For Arduino Uno and Nano (ATmega328P,
// 16 MHz). The host computes the frames; see README.md.

#include <avr/interrupt.h>

extern "C" {
#include "console.h"
#include "player.h"
#include "serial_port.h"
}

// Replaces setup() and loop(): the Arduino core, its timers and Serial are not linked, so the program is the same with
// and without the Arduino tools.
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

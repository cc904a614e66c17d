// shirube motor controller: two wheels with encoders, controlled with ROSArduinoBridge's serial protocol. For
// Arduino Uno and Nano (ATmega328P, 16 MHz); see README.md.

#include <avr/interrupt.h>

extern "C" {
#include "clock.h"
#include "console.h"
#include "drive.h"
#include "encoders.h"
#include "motors.h"
#include "serial_port.h"
#include "watchdog.h"
}

// Own main() instead of setup() and loop(): the Arduino core, its timers and Serial are not linked, so the program is the
// same with and without the Arduino tools.
int main()
{
    motors_begin();
    watchdog_begin();
    encoders_begin();
    clock_begin();
    serial_port_begin();
    sei();
    for (;;) {
        watchdog_reset();
        console_poll();
        drive_poll();
        serial_port_sleep();
    }
}

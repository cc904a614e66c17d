// shirube motor controller: two wheels with encoders under a host that speaks ROSArduinoBridge's serial protocol. For
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

// In place of setup() and loop(): the Arduino core, its timers and its Serial stay out, so this is the same program
// with and without it.
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

// An ATmega328P at 16 MHz in simavr with its serial line, controlled by lines of text; the base of every firmware's
// simulator.
//
//   s HEX   send bytes to the controller
//   r US    run for US microseconds
//   l US    run until the controller ends a line, at most US microseconds
//
// After r and l it prints one line: the bytes that the controller sent meanwhile, in hex.
#pragma once

#include <simavr/sim_avr.h>
#include <stdint.h>

#define CHIP_FREQUENCY 16000000
#define CHIP_LINE_MAX 16384

// Power on with a program.
avr_t *chip_begin(const char *firmware_path);

// Execute a line; an unknown command ends the program.
void chip_execute(const char *line);

// Run for some microseconds, or until the counter has grown by count if that is not 0, and print the received bytes.
void chip_run(uint64_t microseconds, const unsigned *counter, unsigned count);

// Exit with an error message.
void chip_fail(const char *what) __attribute__((noreturn));

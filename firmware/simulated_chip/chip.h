// An ATmega328P of 16 MHz in simavr with its serial line, driven by lines of text. Every firmware's simulator is built
// on it.
//
//   s HEX   send bytes to the controller
//   r US    run so many microseconds
//   l US    run until the controller ends a line, or so many microseconds
//
// After r and l it answers with one line: the bytes that the controller sent meanwhile, in hex.
#pragma once

#include <simavr/sim_avr.h>
#include <stdint.h>

#define CHIP_FREQUENCY 16000000
#define CHIP_LINE_MAX 16384

// Power on with a program.
avr_t *chip_begin(const char *firmware_path);

// Do what a line says; one that is not listed above ends the program.
void chip_obey(const char *line);

// Run so many microseconds, or until the counter has grown by count where that is not 0, and answer.
void chip_run(uint64_t microseconds, const unsigned *counter, unsigned count);

// End the program and say why.
void chip_fail(const char *what) __attribute__((noreturn));

// Runs the firmware for the tests: an ATmega328P with serial port, EEPROM and pins.
//
//   simulator FIRMWARE.elf EEPROM.bin PINS.vcd
//
// Reads the commands of simulated_chip/chip.h from standard input, and
//   e N     run until the controller has written N bytes of its EEPROM, or for a second; same reply as r
// At the end of the input the power is switched off; the EEPROM is saved to its file.

#include <simavr/avr_eeprom.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../simulated_chip/chip.h"
#include "pins.h"

#define EEPROM_SIZE 1024

#define EECR 0x3f
#define EEPE 1

static avr_t *avr;
static unsigned eeprom_writes;

static void load_eeprom(const char *path)
{
    uint8_t bytes[EEPROM_SIZE];
    memset(bytes, 0xff, sizeof bytes);
    FILE *file = fopen(path, "rb");
    if (file) {
        if (fread(bytes, 1, sizeof bytes, file) != sizeof bytes)
            chip_fail("the EEPROM's file is too short");
        fclose(file);
    }
    avr_eeprom_desc_t all = {.ee = bytes, .offset = 0, .size = sizeof bytes};
    avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &all);
}

static void save_eeprom(const char *path)
{
    uint8_t bytes[EEPROM_SIZE];
    avr_eeprom_desc_t all = {.ee = bytes, .offset = 0, .size = sizeof bytes};
    avr_ioctl(avr, AVR_IOCTL_EEPROM_GET, &all);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, sizeof bytes, file) != sizeof bytes || fclose(file))
        chip_fail("the EEPROM's file cannot be written");
}

// simavr writes a byte of the EEPROM immediately, the chip takes 3.3 ms.
static void count_eeprom_write(avr_t *writing, avr_io_addr_t address, uint8_t value, void *parameter)
{
    (void)writing, (void)address, (void)parameter;
    eeprom_writes += value >> EEPE & 1;
}

int main(int count, char **arguments)
{
    static char line[CHIP_LINE_MAX];
    if (count != 4)
        chip_fail("usage: simulator FIRMWARE.elf EEPROM.bin PINS.vcd");
    avr = chip_begin(arguments[1]);
    load_eeprom(arguments[2]);
    if (!pins_begin(avr, arguments[3]))
        chip_fail("the pins' file cannot be written");
    avr_register_io_write(avr, EECR, count_eeprom_write, NULL);
    while (fgets(line, sizeof line, stdin)) {
        if (line[0] == 'e')
            chip_run(1000000, &eeprom_writes, atoi(line + 1));
        else
            chip_execute(line);
    }
    if (!pins_end())
        chip_fail("the pins' file cannot be written");
    save_eeprom(arguments[2]);
    return 0;
}

// Runs the firmware in simavr for the tests: a whole ATmega328P with its serial line, its EEPROM and its pins.
//
//   simulator FIRMWARE.elf EEPROM.bin PINS.vcd
//
// Reads commands from its standard input:
//   s HEX   send bytes to the controller
//   r US    run so many microseconds
//   l US    run until the controller ends a line, or so many microseconds
//   e N     run until the controller has written N bytes of its EEPROM, or a second
// After r, l and e it answers with one line: the bytes that the controller sent meanwhile, in hex. At the end of the input
// the power goes off: the EEPROM stays as it is then, in its file.

#include <simavr/avr_eeprom.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pins.h"

#define FREQUENCY 16000000
#define EEPROM_SIZE 1024
#define LINE_SIZE 8192

#define EECR 0x3f
#define EEPE 1

static avr_t *avr;
static uint8_t to_send[LINE_SIZE];
static size_t sent, to_send_length;
static bool uart_takes;
static unsigned lines_received, eeprom_writes;

static void send_more(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq, (void)value, (void)parameter;
    uart_takes = true;
    while (uart_takes && sent < to_send_length)
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT), to_send[sent++]);
}

static void wait(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq, (void)value, (void)parameter;
    uart_takes = false;
}

static void receive(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq, (void)parameter;
    printf("%02x", value & 0xff);
    lines_received += value == '\n';
}

// While the controller sleeps time passes at once.
static void sleep_at_once(avr_t *sleeping, avr_cycle_count_t cycles)
{
    (void)sleeping, (void)cycles;
}

// What simavr has to say must not be taken for answers.
static void log_to_stderr(avr_t *speaking, const int level, const char *format, va_list arguments)
{
    (void)speaking;
    if (level <= LOG_WARNING)
        vfprintf(stderr, format, arguments);
}

static void fail(const char *what)
{
    fprintf(stderr, "simulator: %s\n", what);
    exit(1);
}

static void begin(const char *firmware_path)
{
    elf_firmware_t firmware = {0};
    avr_global_logger_set(log_to_stderr);
    if (elf_read_firmware(firmware_path, &firmware))
        fail("the firmware cannot be read");
    avr = avr_make_mcu_by_name("atmega328p");
    avr_init(avr);
    firmware.frequency = FREQUENCY;
    // What the chip keeps comes from the file, not from the program.
    firmware.eesize = 0;
    avr_load_firmware(avr, &firmware);
    avr->sleep = sleep_at_once;

    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), receive, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), send_more, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), wait, NULL);
}

static void load_eeprom(const char *path)
{
    uint8_t bytes[EEPROM_SIZE];
    memset(bytes, 0xff, sizeof bytes);
    FILE *file = fopen(path, "rb");
    if (file) {
        if (fread(bytes, 1, sizeof bytes, file) != sizeof bytes)
            fail("the EEPROM's file is too short");
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
        fail("the EEPROM's file cannot be written");
}

static void queue(const char *hex)
{
    if (sent == to_send_length)
        sent = to_send_length = 0;
    for (unsigned byte; sscanf(hex, " %2x", &byte) == 1; hex += 2 + (*hex == ' ')) {
        if (to_send_length == sizeof to_send)
            fail("too much to send");
        to_send[to_send_length++] = byte;
    }
    if (uart_takes)
        send_more(NULL, 0, NULL);
}

// simavr writes a byte of the EEPROM at once where the chip takes 3.3 ms.
static void count_eeprom_write(avr_t *writing, avr_io_addr_t address, uint8_t value, void *parameter)
{
    (void)writing, (void)address, (void)parameter;
    eeprom_writes += value >> EEPE & 1;
}

static void run(uint64_t microseconds, const unsigned *counter, unsigned count)
{
    uint64_t end = avr->cycle + microseconds * (FREQUENCY / 1000000);
    unsigned before = *counter;
    while (avr->cycle < end && !(count && *counter - before >= count)) {
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed)
            fail("the controller crashed");
    }
    printf("\n");
    fflush(stdout);
}

static void obey(const char *line)
{
    uint64_t number = strtoull(line + 1, NULL, 10);
    switch (line[0]) {
    case 's': queue(line + 1); break;
    case 'r': run(number, &lines_received, 0); break;
    case 'l': run(number, &lines_received, 1); break;
    case 'e': run(1000000, &eeprom_writes, number); break;
    default: fail("unknown command");
    }
}

int main(int count, char **arguments)
{
    static char line[LINE_SIZE * 2];
    if (count != 4)
        fail("usage: simulator FIRMWARE.elf EEPROM.bin PINS.vcd");
    begin(arguments[1]);
    load_eeprom(arguments[2]);
    if (!pins_begin(avr, arguments[3]))
        fail("the pins' file cannot be written");
    avr_register_io_write(avr, EECR, count_eeprom_write, NULL);
    while (fgets(line, sizeof line, stdin))
        obey(line);
    if (!pins_end())
        fail("the pins' file cannot be written");
    save_eeprom(arguments[2]);
    return 0;
}

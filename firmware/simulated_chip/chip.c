#include "chip.h"

#include <simavr/avr_uart.h>
#include <simavr/sim_elf.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#define TO_SEND_MAX (CHIP_LINE_MAX / 2)

static avr_t *avr;
static uint8_t to_send[TO_SEND_MAX];
static size_t sent, to_send_length;
static bool uart_takes;
static unsigned lines_received;

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

// Skip the time while the controller sleeps.
static void sleep_at_once(avr_t *sleeping, avr_cycle_count_t cycles)
{
    (void)sleeping, (void)cycles;
}

// Keep simavr's messages out of the replies.
static void log_to_stderr(avr_t *speaking, const int level, const char *format, va_list arguments)
{
    (void)speaking;
    if (level <= LOG_ERROR)
        vfprintf(stderr, format, arguments);
}

void chip_fail(const char *what)
{
    fprintf(stderr, "simulator: %s\n", what);
    exit(1);
}

avr_t *chip_begin(const char *firmware_path)
{
    elf_firmware_t firmware = {0};
    avr_global_logger_set(log_to_stderr);
    if (elf_read_firmware(firmware_path, &firmware))
        chip_fail("cannot read the firmware");
    avr = avr_make_mcu_by_name("atmega328p");
    avr_init(avr);
    firmware.frequency = CHIP_FREQUENCY;
    // The EEPROM is not initialized by the program.
    firmware.eesize = 0;
    avr_load_firmware(avr, &firmware);
    avr->sleep = sleep_at_once;
    avr->vcc = avr->avcc = avr->aref = 5000;

    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), receive, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), send_more, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), wait, NULL);
    return avr;
}

static void queue(const char *hex)
{
    if (sent == to_send_length)
        sent = to_send_length = 0;
    for (unsigned byte; sscanf(hex, " %2x", &byte) == 1; hex += 2 + (*hex == ' ')) {
        if (to_send_length == sizeof to_send)
            chip_fail("too much to send");
        to_send[to_send_length++] = byte;
    }
    if (uart_takes)
        send_more(NULL, 0, NULL);
}

void chip_run(uint64_t microseconds, const unsigned *counter, unsigned count)
{
    uint64_t end = avr->cycle + microseconds * (CHIP_FREQUENCY / 1000000);
    unsigned before = *counter;
    while (avr->cycle < end && !(count && *counter - before >= count)) {
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed)
            chip_fail("the controller crashed");
    }
    printf("\n");
    fflush(stdout);
}

void chip_execute(const char *line)
{
    uint64_t microseconds = strtoull(line + 1, NULL, 10);
    switch (line[0]) {
    case 's': queue(line + 1); break;
    case 'r': chip_run(microseconds, &lines_received, 0); break;
    case 'l': chip_run(microseconds, &lines_received, 1); break;
    default: chip_fail("unknown command");
    }
}

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
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_vcd_file.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FREQUENCY 16000000
#define EEPROM_SIZE 1024
#define LINE_SIZE 8192
#define VCD_FLUSH_US 1000

#define PORTB 0x25
#define EECR 0x3f
#define EEPE 1
#define TCCR1A 0x80

// A half of the lamp: its pin, the bits of TCCR1A that say what a match does to it, and the match's interrupt.
struct half {
    const char *name;
    uint8_t port_bit, mode_bit, vector;
    avr_irq_t *level;
};

static avr_t *avr;
static struct half halves[] = {
    {.name = "half_a", .port_bit = 1, .mode_bit = 6, .vector = 11},
    {.name = "half_b", .port_bit = 2, .mode_bit = 4, .vector = 12},
};
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

static bool is_timers(const struct half *half)
{
    return avr->data[TCCR1A] >> half->mode_bit & 3;
}

static void set_mode(avr_t *writing, avr_io_addr_t address, uint8_t value, void *parameter)
{
    (void)address;
    struct half *half = parameter;
    if (!(value >> half->mode_bit & 3))
        avr_raise_irq(half->level, writing->data[PORTB] >> half->port_bit & 1);
}

static void follow_port(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    struct half *half = parameter;
    if (!is_timers(half))
        avr_raise_irq(half->level, value & 1);
}

// The datasheet's output compare unit, at the tick of simavr's match. Its own, up to version 1.6, also switches the
// pin whenever the time of the next match is set, as if the timer had run over in a PWM mode.
static void match(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    struct half *half = parameter;
    if (value && is_timers(half))
        avr_raise_irq(half->level, avr->data[TCCR1A] >> half->mode_bit & 1);
}

static void record(const char *path, avr_vcd_t *vcd)
{
    avr_vcd_init(avr, path, vcd, VCD_FLUSH_US);
    for (size_t i = 0; i < 2; i++) {
        struct half *half = halves + i;
        half->level = avr_alloc_irq(&avr->irq_pool, 0, 1, &half->name);
        half->level->flags |= IRQ_FLAG_FILTERED;
        avr_irq_t *port = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), half->port_bit);
        avr_irq_register_notify(port, follow_port, half);
        avr_register_io_write(avr, TCCR1A, set_mode, half);
        avr_irq_register_notify(avr_get_interrupt_irq(avr, half->vector) + AVR_INT_IRQ_PENDING, match, half);
        avr_vcd_add_signal(vcd, half->level, 1, half->name);
    }
    // How long the interrupt runs that prepares the next match.
    avr_vcd_add_signal(vcd, avr_get_interrupt_irq(avr, halves[0].vector) + AVR_INT_IRQ_RUNNING, 1, "preparing");
    avr_vcd_start(vcd);
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
    avr_vcd_t vcd = {0};
    if (count != 4)
        fail("usage: simulator FIRMWARE.elf EEPROM.bin PINS.vcd");
    begin(arguments[1]);
    load_eeprom(arguments[2]);
    record(arguments[3], &vcd);
    avr_register_io_write(avr, EECR, count_eeprom_write, NULL);
    while (fgets(line, sizeof line, stdin))
        obey(line);
    avr_vcd_close(&vcd);
    save_eeprom(arguments[2]);
    return 0;
}

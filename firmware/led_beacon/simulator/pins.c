// The pins are computed as by the output compare unit of the datasheet, not by simavr. simavr, up to version 1.6, also
// switches them whenever the compare register is written, and while the controller is awake it updates its timers only
// between two instructions. A match is therefore dated back to its due time.

#include "pins.h"

#include <simavr/avr_ioport.h>
#include <stdio.h>

#define PORTB 0x25
#define TCCR1A 0x80
#define TCCR1B 0x81
#define TIMER_PERIOD 0x10000
// Duration of a cycle (62.5 ns) in the unit of the dump (100 ps).
#define CYCLE_UNITS 625

// A half of the lamp: its pin, its mode bits in TCCR1A, its compare register and interrupt.
struct half {
    char alias;
    uint8_t port_bit, mode_bit, compare, vector;
    int level;
};

static struct half halves[] = {
    {.alias = 'a', .port_bit = 1, .mode_bit = 6, .compare = 0x88, .vector = 11, .level = -1},
    {.alias = 'b', .port_bit = 2, .mode_bit = 4, .compare = 0x8a, .vector = 12, .level = -1},
};
static avr_t *avr;
static FILE *dump;
static avr_cycle_count_t last_cycle, timer_begin;

static void write_change(avr_cycle_count_t cycle, char alias, int level)
{
    if (cycle > last_cycle)
        last_cycle = cycle;
    fprintf(dump, "#%llu\n%d%c\n", (unsigned long long)last_cycle * CYCLE_UNITS, level, alias);
}

static void set_level(struct half *half, avr_cycle_count_t cycle, int level)
{
    if (level != half->level)
        write_change(cycle, half->alias, level);
    half->level = level;
}

static bool is_timers(const struct half *half, uint8_t tccr1a)
{
    return tccr1a >> half->mode_bit & 3;
}

static void follow_port(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    struct half *half = parameter;
    if (!is_timers(half, avr->data[TCCR1A]))
        set_level(half, avr->cycle, value & 1);
}

static void set_mode(avr_t *writing, avr_io_addr_t address, uint8_t value, void *parameter)
{
    (void)address;
    struct half *half = parameter;
    if (!is_timers(half, value))
        set_level(half, writing->cycle, writing->data[PORTB] >> half->port_bit & 1);
}

static void begin_timer(avr_t *writing, avr_io_addr_t address, uint8_t value, void *parameter)
{
    (void)address, (void)value, (void)parameter;
    timer_begin = writing->cycle;
}

static void match(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq;
    struct half *half = parameter;
    if (!value || !is_timers(half, avr->data[TCCR1A]))
        return;
    uint32_t due = avr->data[half->compare] + (avr->data[half->compare + 1] << 8) + 1;
    avr_cycle_count_t late = (avr->cycle - timer_begin - due) % TIMER_PERIOD;
    set_level(half, avr->cycle - late, avr->data[TCCR1A] >> half->mode_bit & 1);
}

static void prepare(struct avr_irq_t *irq, uint32_t value, void *parameter)
{
    (void)irq, (void)parameter;
    write_change(avr->cycle, 'p', value);
}

bool pins_begin(avr_t *recorded, const char *path)
{
    avr = recorded;
    dump = fopen(path, "w");
    if (!dump)
        return false;
    fprintf(dump, "$timescale 100ps $end\n$scope module lamp $end\n$var wire 1 a half_a $end\n"
                  "$var wire 1 b half_b $end\n$var wire 1 p preparing $end\n$upscope $end\n$enddefinitions $end\n"
                  "$dumpvars\nxa\nxb\n0p\n$end\n");
    avr_register_io_write(avr, TCCR1B, begin_timer, NULL);
    for (struct half *half = halves; half < halves + 2; half++) {
        avr_irq_t *port = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), half->port_bit);
        avr_irq_register_notify(port, follow_port, half);
        avr_register_io_write(avr, TCCR1A, set_mode, half);
        avr_irq_register_notify(avr_get_interrupt_irq(avr, half->vector) + AVR_INT_IRQ_PENDING, match, half);
    }
    avr_irq_register_notify(avr_get_interrupt_irq(avr, halves[0].vector) + AVR_INT_IRQ_RUNNING, prepare, NULL);
    return true;
}

bool pins_end(void)
{
    return !fclose(dump);
}

#include "wheel.h"

#include <math.h>
#include <simavr/avr_ioport.h>

void wheel_show(const struct wheel *wheel, avr_t *avr)
{
    static const uint8_t levels_of_tick[4] = {0, 1, 3, 2};
    uint8_t levels = levels_of_tick[wheel->ticks & 3];
    // simavr resets the levels of inputs when the program writes to their port, and restores them from here.
    avr_ioport_external_t inputs = {.name = wheel->port, .mask = 3 << wheel->a, .value = levels << wheel->a};
    avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(wheel->port), &inputs);
    for (int i = 0; i < 2; i++)
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(wheel->port), wheel->a + i), levels >> i & 1);
}

void wheel_turn(struct wheel *wheel, avr_t *avr, double voltage, double seconds)
{
    wheel->speed += (voltage * wheel->speed_max - wheel->speed) * -expm1(-seconds / wheel->lag);
    wheel->position += wheel->speed * seconds;
    int64_t ticks = floor(wheel->position);
    if (ticks == wheel->ticks)
        return;
    wheel->ticks += ticks > wheel->ticks ? 1 : -1;
    wheel_show(wheel, avr);
}

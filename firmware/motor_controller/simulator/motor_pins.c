#include "motor_pins.h"

#include <stdbool.h>

#include "../../simulated_chip/chip.h"

#define COMPARE_CLEARS 2
#define WAVEFORM_BITS 3
#define PHASE_CORRECT_8_BIT 1
#define WAVEFORM_BIT_2 8
#define CLOCK_BITS 7
#define COUNTER_TOP 255.0

struct port {
    uint8_t ddr, port;
};

// An output pin and the timer compare unit that may drive it.
struct output {
    struct port port;
    uint8_t bit, control_a, control_b, mode_bit, compare;
};

static const struct port port_b = {.ddr = 0x24, .port = 0x25}, port_d = {.ddr = 0x2a, .port = 0x2b};
static const struct output d5 = {port_d, 5, 0x44, 0x45, 4, 0x48};
static const struct output d6 = {port_d, 6, 0x44, 0x45, 6, 0x47};
static const struct output d9 = {port_b, 1, 0x80, 0x81, 6, 0x88};
static const struct output d10 = {port_b, 2, 0x80, 0x81, 4, 0x8a};

static bool is_high(const avr_t *avr, struct port port, uint8_t bit)
{
    return avr->data[port.ddr] & avr->data[port.port] & 1 << bit;
}

// Duty cycle of an output; a pin that is not an output is pulled down.
static double duty(const avr_t *avr, const struct output *output)
{
    uint8_t a = avr->data[output->control_a], b = avr->data[output->control_b];
    uint8_t mode = a >> output->mode_bit & 3;
    if (!(avr->data[output->port.ddr] & 1 << output->bit))
        return 0;
    if (!mode)
        return is_high(avr, output->port, output->bit);
    if (mode != COMPARE_CLEARS || (a & WAVEFORM_BITS) != PHASE_CORRECT_8_BIT || b & WAVEFORM_BIT_2)
        chip_fail("a motor's timer is not in 8-bit phase correct PWM mode");
    return b & CLOCK_BITS ? avr->data[output->compare] / COUNTER_TOP : 0;
}

static double voltage(const avr_t *avr, const struct output *forward, const struct output *backward, uint8_t enable)
{
    return is_high(avr, port_b, enable) ? duty(avr, forward) - duty(avr, backward) : 0;
}

double left_voltage(const avr_t *avr)
{
    return voltage(avr, &d10, &d6, 5);
}

double right_voltage(const avr_t *avr)
{
    return voltage(avr, &d9, &d5, 4);
}

// Simulator of the firmware for the tests: an ATmega328P with its serial line, two motors and their encoders.
//
//   simulator FIRMWARE.elf
//
// Reads the commands of simulated_chip/chip.h from its standard input, and
//   w                   prints the ground truth: microseconds since power on, ticks left and right, PWM left and right
//                       (-255 to 255, from the pins), resets since power on
//   t LEFT RIGHT LAG    sets the speeds of the motors at full PWM [ticks/s] and their time constant [ms]
//   h                   hangs the program until the next reset; interrupts continue
//   k ADDRESS HEX       writes bytes into the memory

#include <stdio.h>
#include <stdlib.h>

#include "../../simulated_chip/chip.h"
#include "motor_pins.h"
#include "wheel.h"

// Short enough for 50 000 ticks/s.
#define STEP_CYCLES 320
#define JUMP_TO_ITSELF 0xcfff

static avr_t *avr;
static struct wheel left = {.port = 'D', .a = 2, .speed_max = 3000, .lag = 0.1};
static struct wheel right = {.port = 'C', .a = 4, .speed_max = 3000, .lag = 0.1};
static unsigned resets;
static uint16_t *hung_at, hung_instruction;
static void (*reset_chip)(struct avr_t *avr);

static avr_cycle_count_t turn_wheels(avr_t *turning, avr_cycle_count_t when, void *parameter)
{
    (void)parameter;
    double seconds = (double)STEP_CYCLES / CHIP_FREQUENCY;
    wheel_turn(&left, turning, left_voltage(turning), seconds);
    wheel_turn(&right, turning, right_voltage(turning), seconds);
    return when + STEP_CYCLES;
}

static void begin_wheels(void)
{
    wheel_show(&left, avr);
    wheel_show(&right, avr);
    avr_cycle_timer_register(avr, STEP_CYCLES, turn_wheels, NULL);
}

static void hang(void)
{
    hung_at = (uint16_t *)(avr->flash + avr->pc);
    hung_instruction = *hung_at;
    *hung_at = JUMP_TO_ITSELF;
}

static void reset(avr_t *resetting)
{
    if (hung_at)
        *hung_at = hung_instruction;
    hung_at = NULL;
    resets++;
    reset_chip(resetting);
    begin_wheels();
}

static void publish_ground_truth(void)
{
    printf("%llu %lld %lld %.0f %.0f %u\n", (unsigned long long)avr->cycle / (CHIP_FREQUENCY / 1000000),
           (long long)left.ticks, (long long)right.ticks, 255 * left_voltage(avr), 255 * right_voltage(avr), resets);
    fflush(stdout);
}

static void change_motors(const char *text)
{
    double lag;
    if (sscanf(text, "%lf %lf %lf", &left.speed_max, &right.speed_max, &lag) != 3)
        chip_fail("t needs three numbers");
    left.lag = right.lag = lag / 1000;
}

static void poke(const char *text)
{
    char *hex;
    uint16_t address = strtoul(text, &hex, 0);
    for (unsigned byte; sscanf(hex, " %2x", &byte) == 1; hex += 2 + (*hex == ' '))
        avr->data[address++] = byte;
}

static void execute(const char *line)
{
    switch (line[0]) {
    case 'w': publish_ground_truth(); break;
    case 't': change_motors(line + 1); break;
    case 'h': hang(); break;
    case 'k': poke(line + 1); break;
    default: chip_execute(line);
    }
}

int main(int count, char **arguments)
{
    static char line[CHIP_LINE_MAX];
    if (count != 2)
        chip_fail("usage: simulator FIRMWARE.elf");
    avr = chip_begin(arguments[1]);
    reset_chip = avr->reset;
    avr->reset = reset;
    begin_wheels();
    while (fgets(line, sizeof line, stdin))
        execute(line);
    return 0;
}

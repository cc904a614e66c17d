#include "speed_loop.h"

#include <stdbool.h>

#include "motors.h"

static int32_t limited(int32_t value, int32_t limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

int16_t speed_loop_step(struct speed_loop *loop, const struct gains *gains, int16_t ticks)
{
    int32_t limit = (int32_t)PWM_MAX * gains->o;
    int32_t error = (int32_t)loop->target - ticks;
    int32_t change = gains->p * error - gains->d * ((int32_t)ticks - loop->last_ticks) + loop->sum;
    int32_t output = loop->output + change;
    bool is_cut = output > limit || output < -limit;
    loop->sum = is_cut ? 0 : limited(loop->sum + gains->i * error, limit);
    loop->output = limited(output, limit);
    loop->last_ticks = ticks;
    return loop->output / gains->o;
}

void speed_loop_change_gains(struct speed_loop *loop, const struct gains *from, const struct gains *to)
{
    loop->output = loop->output / from->o * to->o;
    // It is 0 at a steady speed.
    loop->sum = 0;
}

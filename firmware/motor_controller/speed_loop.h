// Holds one wheel's speed: ROSArduinoBridge's control law, so gains that were tuned for that fit this too.
//
// Every frame the output grows by (P e - D (v - v') + sum of I e) / O with v the ticks of this frame, v' those of the last
// one and e what v lacks. The output is kept in parts of 1/O: whole steps of PWM would lose every small correction and
// leave the wheel too slow. At the limit of the PWM the output is cut and the sum begins anew, so neither winds up.
#pragma once

#include <stdint.h>

#define TICKS_PER_FRAME_MAX 1000
// With these limits nothing overflows 32 bits.
#define GAIN_MAX 10000

struct gains {
    int16_t p, d, i, o;
};

struct speed_loop {
    int16_t target, last_ticks;
    int32_t output, sum;
};

// Next PWM, from the ticks of the frame that is over.
int16_t speed_loop_step(struct speed_loop *loop, const struct gains *gains, int16_t ticks);

// Carry the output over to other gains without a jump.
void speed_loop_change_gains(struct speed_loop *loop, const struct gains *from, const struct gains *to);

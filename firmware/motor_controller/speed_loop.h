// Speed control of one wheel: ROSArduinoBridge's control law, so that gains tuned for it can be reused.
//
// Each frame the output grows by (P e - D (v - v') + sum of I e) / O with v the ticks of this frame, v' those of the last
// one and e the error of v. The output is stored in units of 1/O: whole PWM steps would lose small corrections and leave
// the wheel too slow. At the PWM limit the output is clamped and the sum is reset (anti-windup).
#pragma once

#include <stdint.h>

#define TICKS_PER_FRAME_MAX 1000
// With these limits 32 bits do not overflow.
#define GAIN_MAX 10000

struct gains {
    int16_t p, d, i, o;
};

struct speed_loop {
    int16_t target, last_ticks;
    int32_t output, sum;
};

// Next PWM from the ticks of the last frame.
int16_t speed_loop_step(struct speed_loop *loop, const struct gains *gains, int16_t ticks);

// Change the gains without a jump of the output.
void speed_loop_change_gains(struct speed_loop *loop, const struct gains *from, const struct gains *to);

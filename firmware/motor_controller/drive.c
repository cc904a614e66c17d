#include "drive.h"

#include <stdbool.h>

#include "clock.h"
#include "encoders.h"
#include "motors.h"

static enum { RESTS, HOLDS_SPEED, HAS_PWM } state;
static struct gains gains = {.p = 20, .d = 12, .i = 0, .o = 50};
static struct speed_loop loops[WHEEL_COUNT];
static int32_t frame_ticks[WHEEL_COUNT];
static uint16_t ordered_at, frame_begin, auto_stop = AUTO_STOP_MAX;

static void stop(void)
{
    static const int16_t nothing[WHEEL_COUNT];
    motors_set(nothing);
    state = RESTS;
}

// Restart the speed control; the first frame is a whole one.
static void begin_to_hold(void)
{
    static const struct speed_loop fresh;
    loops[LEFT] = loops[RIGHT] = fresh;
    encoders_read(frame_ticks);
    frame_begin = clock_milliseconds();
    state = HOLDS_SPEED;
}

static void end_frame(void)
{
    int32_t ticks[WHEEL_COUNT];
    int16_t pwm[WHEEL_COUNT];
    encoders_read(ticks);
    for (enum wheel wheel = LEFT; wheel < WHEEL_COUNT; wheel++) {
        pwm[wheel] = speed_loop_step(&loops[wheel], &gains, (uint32_t)ticks[wheel] - frame_ticks[wheel]);
        frame_ticks[wheel] = ticks[wheel];
    }
    motors_set(pwm);
}

void drive_at_speed(const int16_t ticks_per_frame[WHEEL_COUNT])
{
    ordered_at = clock_milliseconds();
    if (!ticks_per_frame[LEFT] && !ticks_per_frame[RIGHT])
        return stop();
    if (state != HOLDS_SPEED)
        begin_to_hold();
    loops[LEFT].target = ticks_per_frame[LEFT];
    loops[RIGHT].target = ticks_per_frame[RIGHT];
}

void drive_with_pwm(const int16_t pwm[WHEEL_COUNT])
{
    ordered_at = clock_milliseconds();
    motors_set(pwm);
    state = HAS_PWM;
}

void drive_set_gains(const struct gains *next)
{
    for (enum wheel wheel = LEFT; wheel < WHEEL_COUNT; wheel++)
        speed_loop_change_gains(&loops[wheel], &gains, next);
    gains = *next;
}

void drive_set_auto_stop(uint16_t milliseconds)
{
    auto_stop = milliseconds;
}

void drive_reset_encoders(void)
{
    if (state == HOLDS_SPEED)
        stop();
    encoders_reset();
}

void drive_poll(void)
{
    uint16_t now = clock_milliseconds();
    if (state != RESTS && (uint16_t)(now - ordered_at) > auto_stop)
        stop();
    if (state != HOLDS_SPEED || (uint16_t)(now - frame_begin) < FRAME_MILLISECONDS)
        return;
    frame_begin += FRAME_MILLISECONDS;
    end_frame();
}

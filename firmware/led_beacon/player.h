// Plays frames on the two halves of the lamp: pin 9 (OC1A) and pin 10 (OC1B).
//
// Timer1 switches the pins in hardware, at the tick set one step before. Interrupt latency has no effect as long as it
// is shorter than the step.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "frame.h"

// Initialize; the lamp is constantly on.
void player_begin(void);

// Buffer of FRAME_MAX bytes for the next frame, or null while a frame is queued.
uint8_t *player_free_frame(void);

// Queue the free frame, which must be valid; it starts at the end of the current packet.
void player_play_free_frame(void);

// Stop playing, constantly on; the current or queued frame is kept.
void player_stop(void);

// Play the frame from its beginning; false if there is none.
bool player_resume(void);

bool player_is_playing(void);

// Whether the frame has completed its number of plays; it continues until another one follows.
bool player_is_done(void);

// Number of completed repetitions, modulo 256.
uint8_t player_rounds(void);

// The current frame, null for none.
const uint8_t *player_frame(void);

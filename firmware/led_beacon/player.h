// Plays frames on the two halves of the lamp: pin 9 (OC1A) and pin 10 (OC1B).
//
// Timer1 itself switches the pins, at the tick that was set one step before. An interrupt that comes late
// changes nothing as long as it comes within the step.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "frame.h"

// The lamp shines steadily.
void player_begin(void);

// Room for a frame of FRAME_MAX bytes that is not playing, or null while another one waits to be played.
uint8_t *player_free_frame(void);

// Play what was put into the free frame, from where the packet that is playing now ends. It must have no fault.
void player_play_free_frame(void);

// Shine steadily; keep the frame, or the one that waits.
void player_stop(void);

// Play the frame from its beginning; false where there is none.
bool player_resume(void);

bool player_is_playing(void);

// Whether the frame has been played as often as it asks for; it goes on until another one follows.
bool player_is_done(void);

// How often a frame has come to its end, modulo 256.
uint8_t player_rounds(void);

// The frame that plays or would, null for none.
const uint8_t *player_frame(void);

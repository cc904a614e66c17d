// Keeps a frame in the EEPROM.
//
// Two slots of 512 bytes take turns. A slot is a sequence number, the frame and a checksum of both. The number is made
// invalid first and written last, so whenever the power goes, one whole frame is left: the new one or the old one.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Takes up to 1.8 s, while the lamp goes on; false where the EEPROM does not hold what was written.
bool store_write(const uint8_t *frame);

// Copy the newest whole frame; false where there is none. At most FRAME_MAX bytes are written.
bool store_read(uint8_t *frame);

// Stores a frame in the EEPROM.
//
// Two slots of 512 bytes are written alternately. A slot has a sequence number, the frame and a checksum of both. The
// number is invalidated first and written last, so a power failure leaves one complete frame: the new or the old one.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Takes up to 1.8 s, while the lamp continues; false if the EEPROM does not verify.
bool store_write(const uint8_t *frame);

// Copy the newest valid frame; false if there is none. At most FRAME_MAX bytes are written.
bool store_read(uint8_t *frame);

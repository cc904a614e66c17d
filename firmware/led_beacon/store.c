#include "store.h"

#include <avr/eeprom.h>
#include <stddef.h>
#include <util/crc16.h>

#include "frame.h"

#define SLOT_COUNT 2
#define NO_SEQUENCE 0
#define NO_SLOT SLOT_COUNT

struct slot {
    uint8_t sequence;
    uint8_t frame[FRAME_MAX];
    uint16_t crc;
    uint8_t unused;
};

static struct slot slots[SLOT_COUNT] EEMEM;

static uint16_t stored_length(const struct slot *slot)
{
    return eeprom_read_word((const uint16_t *)(slot->frame + offsetof(struct frame_header, length)));
}

static uint16_t stored_crc(const struct slot *slot, uint16_t length)
{
    uint16_t crc = 0;
    for (uint16_t i = 0; i <= length; i++)
        crc = _crc_xmodem_update(crc, eeprom_read_byte(&slot->sequence + i));
    return crc;
}

static bool is_whole(const struct slot *slot)
{
    uint16_t length = stored_length(slot);
    if (eeprom_read_byte(&slot->sequence) == NO_SEQUENCE || length > FRAME_MAX)
        return false;
    return stored_crc(slot, length) == eeprom_read_word(&slot->crc);
}

static bool is_newer(uint8_t sequence, uint8_t than)
{
    return (uint8_t)(sequence - than) < 128;
}

static uint8_t newest_slot(void)
{
    uint8_t newest = NO_SLOT;
    for (uint8_t i = 0; i < SLOT_COUNT; i++) {
        if (!is_whole(slots + i))
            continue;
        uint8_t sequence = eeprom_read_byte(&slots[i].sequence);
        if (newest == NO_SLOT || is_newer(sequence, eeprom_read_byte(&slots[newest].sequence)))
            newest = i;
    }
    return newest;
}

bool store_write(const uint8_t *frame)
{
    uint8_t newest = newest_slot(), sequence = NO_SEQUENCE + 1;
    struct slot *slot = slots;
    if (newest != NO_SLOT) {
        slot = slots + (newest + 1) % SLOT_COUNT;
        sequence = eeprom_read_byte(&slots[newest].sequence) + 1;
        if (sequence == NO_SEQUENCE)
            sequence++;
    }
    uint16_t length = frame_header_of(frame)->length;
    uint16_t crc = _crc_xmodem_update(0, sequence);
    for (uint16_t i = 0; i < length; i++)
        crc = _crc_xmodem_update(crc, frame[i]);
    eeprom_update_byte(&slot->sequence, NO_SEQUENCE);
    eeprom_update_block(frame, slot->frame, length);
    eeprom_update_word(&slot->crc, crc);
    eeprom_update_byte(&slot->sequence, sequence);
    return slots + newest_slot() == slot;
}

bool store_read(uint8_t *frame)
{
    uint8_t newest = newest_slot();
    if (newest == NO_SLOT)
        return false;
    uint16_t length = stored_length(slots + newest);
    eeprom_read_block(frame, slots[newest].frame, length);
    return !frame_fault(frame, length);
}

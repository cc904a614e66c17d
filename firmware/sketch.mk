# How every sketch here is built and flashed without the Arduino tools; a sketch's Makefile sets SKETCH and includes this.

BUILD ?= build
PORT ?= /dev/ttyUSB0
BOOTLOADER_BAUD ?= 115200

SOURCES := $(wildcard *.c)
OBJECTS := $(SOURCES:%.c=$(BUILD)/%.o) $(BUILD)/$(SKETCH).o
FLAGS := -mmcu=atmega328p -DF_CPU=16000000UL -Os -ffunction-sections -fdata-sections -MMD -Wall -Wextra -Werror
SIMULATED_CHIP := $(wildcard ../simulated_chip/*.[ch])

$(BUILD)/$(SKETCH).hex: $(BUILD)/$(SKETCH).elf
	avr-objcopy -O ihex -R .eeprom $< $@
	avr-size $<

$(BUILD)/$(SKETCH).elf: $(OBJECTS)
	avr-gcc -mmcu=atmega328p -Wl,--gc-sections $^ -o $@

$(BUILD)/%.o: %.c | $(BUILD)
	avr-gcc $(FLAGS) -std=c11 -c $< -o $@

$(BUILD)/%.o: %.ino | $(BUILD)
	avr-gcc $(FLAGS) -x c++ -std=c++11 -c $< -o $@

$(BUILD)/simulator: $(wildcard simulator/*.[ch]) $(SIMULATED_CHIP) | $(BUILD)
	gcc -O2 -std=c11 -Wall -Wextra -Werror $(filter %.c,$^) -o $@ -lsimavr -lm

$(BUILD):
	mkdir -p $@

.PHONY: flash clean
flash: $(BUILD)/$(SKETCH).hex
	avrdude -p atmega328p -c arduino -P $(PORT) -b $(BOOTLOADER_BAUD) -U flash:w:$<:i

clean:
	rm -rf $(BUILD)

-include $(OBJECTS:.o=.d)
